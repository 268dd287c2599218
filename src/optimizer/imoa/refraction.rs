//! Refraction of members through the start (paper, eq 26 to 29).

use crate::optimizer::random::uniform;
use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Refraction, eq 26 to 29 in our reading. With probability 0.3 + 0.7 p, p = 1 - exp(-(2 t / T)^2 / 2) (eq
/// 26), one variable is mirrored about the start and shrunk by a ratio from (1, 10) (eq 27). Eq 28 only
/// restates eq 27, so the ratio is drawn; the middle of eq 29's bounds is the least-squares estimate of that
/// variable, the start. Returns `None` if nothing is refracted.
pub(super) fn refracted<const D: usize>(
    member: &[f32; D],
    start: &[f32; D],
    progress: f32,
    generator: &mut Xoshiro128PlusPlus,
) -> Option<[f32; D]> {
    let p = 1.0 - libm::expf(-2.0 * progress * progress);
    if uniform(generator) >= 0.3 + 0.7 * p {
        return None;
    }
    let mut out = *member;
    let variable = generator.next_u32() as usize % if D == 0 { 1 } else { D };
    let ratio = 1.0 + 9.0 * uniform(generator);
    let (x, start) = (out.get_mut(variable)?, start.get(variable)?);
    *x = start - (*x - start) / ratio;
    Some(out)
}

#[cfg(test)]
mod tests {
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
}
