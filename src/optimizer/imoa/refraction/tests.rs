use super::*;
use rand_core::SeedableRng;

#[test]
fn one_variable_goes_to_the_other_side_of_the_start_and_nearer() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(2);
    let (member, start) = ([0.5_f32, -0.2, 0.9, 0.0], [0.1_f32, 0.1, 0.1, 0.1]);
    // Probability 0.3 at the beginning and 0.3 + 0.7 (1 - e^-2) = 0.905 at the end; 4 standard deviations
    // of 10,000 draws.
    for (progress, probability) in [(0.0, 0.3), (0.5, 0.575_43), (1.0, 0.905_27)] {
        let mut count = 0;
        for _ in 0..10_000 {
            let Some(x) = refracted(&member, &start, progress, &mut generator) else { continue };
            count += 1;
            let changed = (0..4).filter(|k| x[*k] != member[*k]).collect::<heapless::Vec<usize, 4>>();
            assert_eq!(changed.len(), 1);
            let ratio = (member[changed[0]] - start[changed[0]]) / (start[changed[0]] - x[changed[0]]);
            assert!((0.999..10.01).contains(&ratio), "{ratio}");
        }
        assert!((f64::from(count) / 1e4 - probability).abs() < 0.02, "{progress}: {count}");
    }
}
