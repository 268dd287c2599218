use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn covariance_times_information_is_one() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut root = [[0.0_f64; WIDE]; GLOBALS];
    for (i, row) in root.iter_mut().enumerate() {
        for (j, element) in row.iter_mut().enumerate().take(GLOBALS).skip(i) {
            let random = f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
            *element = if i == j { 1.0 + random } else { 0.3 * random };
        }
    }
    let information =
        |a: usize, b: usize| root.iter().map(|row| row.get(a).unwrap() * row.get(b).unwrap()).sum::<f64>();
    let mut inverse = [0.0; triangle(GLOBALS)];
    invert(&root, &mut inverse);
    let covariance = |a: usize, b: usize| -> f64 {
        let of = |c: usize, row: usize| column(&inverse, c).get(row).copied().unwrap_or(0.0);
        (0..GLOBALS).map(|c| of(c, a) * of(c, b)).sum()
    };
    for a in 0..GLOBALS {
        for b in 0..GLOBALS {
            let product: f64 = (0..GLOBALS).map(|c| covariance(a, c) * information(c, b)).sum();
            assert!((product - f64::from(u8::from(a == b))).abs() < 1e-9);
        }
    }
}
