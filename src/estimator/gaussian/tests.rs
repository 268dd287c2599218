#![allow(clippy::indexing_slicing)]
use super::*;

#[test]
fn a_narrower_prior_gives_the_posterior_and_the_evidence_of_a_fit_with_it() {
    // y = x + z + noise of variance 0.1, y = 1.3; x ~ N(0, 1), z ~ N(0, 1), then z ~ N(0, 0.2^2).
    let fit = |variance: f64| {
        let s = 1.0 + variance + 0.1;
        (1.3 / s, 1.0 - 1.0 / s, -0.5 * s.ln() - 0.5 * 1.3 * 1.3 / s)
    };
    let s = 2.1;
    let mut mean = [1.3 / s, 1.3 / s];
    let mut covariance = [1.0 - 1.0 / s, -1.0 / s, 1.0 - 1.0 / s];
    let evidence = narrow_last(&mut mean, &mut covariance, 0.2);
    let (expected, before) = (fit(0.04), fit(1.0));
    assert!((mean[0] - expected.0).abs() < 1e-7 && (covariance[0] - expected.1).abs() < 1e-7);
    assert!((evidence - (expected.2 - before.2)).abs() < 1e-7);
}

#[test]
fn two_at_once_are_one_after_the_other_to_the_bit() {
    use rand_core::{Rng, SeedableRng};
    let mut generator = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(7);
    let mut uniform = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
    for n in 2..12_usize {
        for widths in [[0.3, 0.3], [1.0, 0.1], [0.2, 1.0]] {
            let mut mean = [0.0_f32; 12];
            let mut covariance = [0.0_f32; triangle(12)];
            mean.iter_mut().for_each(|x| *x = uniform());
            for i in 0..n {
                for j in 0..=i {
                    covariance[triangle(i) + j] = 0.1 * uniform() + if i == j { 0.6 } else { 0.0 };
                }
            }
            let (mut other_mean, mut other) = (mean, covariance);
            let both = narrow_two(&mut mean[..n], &mut covariance[..triangle(n)], widths);
            let first = narrow_last(&mut other_mean[..n], &mut other[..triangle(n)], widths[0]);
            let second = narrow_last(&mut other_mean[..n - 1], &mut other[..triangle(n - 1)], widths[1]);
            assert_eq!(both, [first, second]);
            assert_eq!(mean[..n - 2], other_mean[..n - 2]);
            assert_eq!(covariance[..triangle(n - 2)], other[..triangle(n - 2)]);
        }
    }
}
