//! The mean over the widths.

use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// A positive definite covariance within a prior of unit width, and a mean.
fn drawn(seed: u64) -> Gaussian<f64> {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
    let mean = core::array::from_fn(|_| uniform());
    let vectors: [[f64; GYRO]; GYRO] = core::array::from_fn(|_| core::array::from_fn(|_| 0.1 * uniform()));
    let mut covariance = [0.0; triangle(GYRO)];
    for i in 0..GYRO {
        for j in 0..=i {
            let own = if i == j { 0.05 } else { 0.0 };
            covariance[triangle(i) + j] = own + vectors.iter().fold(0.0, |sum, v| sum + v[i] * v[j]);
        }
    }
    Gaussian { mean, covariance }
}

/// The uncertainty of an effect that is taken out adds to that of P, but does not draw P away from the value that
/// fits beside the effect.
#[test]
fn what_is_not_known_of_an_effect_inflates_the_average_and_does_not_move_it() {
    for seed in 0..20 {
        let mut sum = Sum::zero();
        for (one, evidence) in [(seed, 0.0), (seed + 100, 0.7)] {
            sum.add(&drawn(one), &[1.0], evidence, [0.0; GROUPS]);
        }
        sum.finish();
        let before = sum.of;
        let by = drawn(seed + 200).mean;
        sum.inflate(&by);
        let after = sum.of;
        assert_eq!(before.mean, after.mean);
        for i in 0..GYRO {
            for j in 0..=i {
                let change = after.covariance[triangle(i) + j] - before.covariance[triangle(i) + j];
                assert!((change - by[i] * by[j]).abs() < 1e-12, "{seed} {i} {j}: {change}");
            }
            assert!((after.unscaled_variance[i] - before.unscaled_variance[i] - by[i] * by[i]).abs() < 1e-12);
        }
    }
}
