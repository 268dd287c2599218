//! Noise, a change of the mean rate, and a jerk.

use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const SIGMA_RAD_S: f32 = 4e-4;

/// Nearly normal noise with [`SIGMA_RAD_S`] on each axis about a mean, rad/s.
fn noisy(random: &mut Xoshiro128PlusPlus, mean: &Vector3<f32>) -> Vector3<f32> {
    let mut normal = || (0..12).map(|_| (random.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5).sum::<f32>();
    mean + Vector3::new(normal(), normal(), normal()) * SIGMA_RAD_S
}

#[test]
fn noise_is_no_change_and_three_of_its_deviations_are_one_within_six_blocks() {
    let random = &mut Xoshiro128PlusPlus::seed_from_u64(3);
    let bias = Vector3::new(0.02, -0.01, 0.03);
    let mut rate = RestRate::new();
    let false_ones = (0..20_000).filter(|_| rate.update(&noisy(random, &bias))).count();
    assert!(false_ones <= 2 && (rate.mean - bias).norm() < SIGMA_RAD_S, "{false_ones} {}", rate.mean);
    let before = rate.mean;
    let other = bias + Vector3::new(0.0, 0.0, 4.0 * SIGMA_RAD_S);
    let seen = (0..20).position(|_| rate.update(&noisy(random, &other)));
    assert!(seen.is_some_and(|blocks| blocks < 6), "{seen:?}");
    // The mean stays that of before.
    assert!((rate.mean - before).norm() < 0.3 * SIGMA_RAD_S, "{}", rate.mean - before);
    (0..20).for_each(|_| _ = rate.update(&noisy(random, &other)));
    rate.accept();
    assert!(!rate.update(&noisy(random, &other)) && (rate.mean - other).norm() < 2.0 * SIGMA_RAD_S);
}

#[test]
fn a_jerk_does_not_end_a_rest_and_a_motion_does() {
    let random = &mut Xoshiro128PlusPlus::seed_from_u64(4);
    let bias = Vector3::new(0.02, -0.01, 0.03);
    let turning = bias + Vector3::new(2e-3, 0.0, 0.0);
    for (interrupted_s, is_seen) in [(1.0, true), (10.0, false)] {
        let mut rate = RestRate::new();
        (0..40).for_each(|_| _ = rate.update(&noisy(random, &bias)));
        rate.interrupt(interrupted_s);
        assert_eq!((0..20).any(|_| rate.update(&noisy(random, &turning))), is_seen);
    }
}
