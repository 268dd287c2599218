//! Average over the scales of the bias's prior: small and large biases, and its errors over many draws.

use super::*;
use crate::estimator::{averaging::GROUPS, gaussian::triangle};

/// A posterior in which P's first element is correlated with the x bias, and half as far from its prior's mean.
fn posterior(mean: [f64; 3], sigma: f64) -> Averaged<f64> {
    let mut of = Averaged {
        mean: [0.0; GYRO],
        covariance: [0.0; triangle(GYRO)],
        decided: 9,
        unscaled_variance: [1.0; GYRO],
        widths: [1.0; GROUPS],
    };
    (0..GYRO).for_each(|i| of.covariance[triangle(i) + i] = if i < NINE { 1.0 } else { sigma * sigma });
    of.covariance[triangle(NINE)] = 0.5 * sigma * sigma;
    of.mean[NINE..].copy_from_slice(&mean);
    of.mean[0] = 0.5 * mean[0];
    of
}

#[test]
fn a_bias_within_its_deviation_shrinks_and_one_far_beyond_it_stays() {
    let after = |mean: [f64; 3], sigma: f64| {
        let mut of = posterior(mean, sigma);
        average(&mut of);
        of
    };
    let small = after([0.1, -0.1, 0.05], 0.2);
    assert!(small.mean[9].abs() < 0.02 && small.mean[10].abs() < 0.02, "{:?}", small.mean);
    assert!(element(&small.covariance, 9, 9) < 0.2 * 0.2 && element(&small.covariance, 9, 9) > 0.0);
    let large = after([0.8, -0.4, 0.6], 0.01);
    assert!((large.mean[9] - 0.8).abs() < 2e-4 && (large.mean[11] - 0.6).abs() < 2e-4, "{:?}", large.mean);
    // P follows.
    for (of, before) in [(small, 0.1), (large, 0.8)] {
        assert!((of.mean[0] - 0.5 * before - 0.5 * (of.mean[9] - before)).abs() < 1e-9);
    }
}

/// Three biases drawn with one scale: over many draws the mean squared error is less than unshrunk, and the stated
/// variance is that error's.
#[test]
fn over_many_draws_it_errs_less_and_says_by_how_much() {
    use rand_core::{Rng, SeedableRng};
    let mut random = rand_xoshiro::Xoshiro128PlusPlus::seed_from_u64(5);
    let mut normal = || (0..12).map(|_| f64::from(random.next_u32()) / 4_294_967_296.0).sum::<f64>() - 6.0;
    let (mut own, mut shrunk, mut stated) = (0.0, 0.0, 0.0);
    let draws = 2_000;
    for draw in 0..draws {
        let scale = f64::from(SCALES[draw % SCALES.len()]);
        let noise = 0.15_f64;
        let truth: [f64; 3] = core::array::from_fn(|_| scale * normal());
        let kept = 1.0 / (1.0 + noise * noise);
        let mut of = posterior(truth.map(|b| kept * (b + noise * normal())), noise * kept.sqrt());
        let before = of.mean;
        average(&mut of);
        for k in 0..3 {
            own += (before[9 + k] - truth[k]).powi(2);
            shrunk += (of.mean[9 + k] - truth[k]).powi(2);
            stated += element(&of.covariance, 9 + k, 9 + k);
        }
    }
    assert!(shrunk < 0.6 * own, "{shrunk} {own}");
    assert!((0.9..1.1).contains(&(shrunk / stated)), "{shrunk} {stated}");
}
