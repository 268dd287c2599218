//! A filter in motion and in doubt, for its tests.

mod certainty;
mod model;
mod scale;

use super::*;
use crate::{
    Config,
    attitude::{AttitudeFlags, error_state::HEADING},
    compensation::GyroModel,
    estimator::KnownAttitude,
    rotation::{exp_matrix, exp_quaternion, matrix},
};
use nalgebra::Quaternion;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const GRAVITY_M_S2: f32 = 9.806_65;

/// A filter that has stood level for 10 s, facing magnetic north, and whose gyro model has just been swapped.
fn doubted() -> AttitudeFilter {
    doubted_at(None)
}

/// The same, at this declination, rad.
fn doubted_at(declination_rad: Option<f32>) -> AttitudeFilter {
    let mut config = Config::default();
    config.earth.declination_rad = declination_rad;
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    for _ in 0..2_000 {
        filter.propagate(0.005, &Vector3::zeros());
        filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
    }
    assert!(!filter.is_doubted());
    let mut other = GyroModel::IDENTITY;
    other.p[1][2] = 0.08;
    filter.model_changed(&GyroModel::IDENTITY, &other, &[0.005; 12]);
    assert!(filter.is_doubted());
    filter
}

/// Angle between the filter's attitude and another, rad, where it is small.
fn off(filter: &AttitudeFilter, rotation: &Vector3<f32>) -> f32 {
    (matrix(&filter.state.propagation.q) - exp_matrix(rotation)).norm() / libm::sqrtf(2.0)
}

/// Scale of a gyro whose factors and couplings err by no more than this, uniform.
fn scale_within(generator: &mut Xoshiro128PlusPlus, factor: f32, coupling: f32) -> Matrix3<f32> {
    let mut within = |bound: f32| (generator.next_u32() as f32 / u32::MAX as f32 - 0.5) * 2.0 * bound;
    Matrix3::from_fn(|r, c| if r == c { 1.0 + within(factor) } else { within(coupling) })
}

/// Flies 20 s by hand with this gyro after a rest. Returns the filter, and the true attitude.
fn turned_by_hand(scale: &Matrix3<f32>, motion: config::Motion) -> (AttitudeFilter, Quaternion<f32>) {
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, motion);
    let truth = turn_by_hand(&mut filter, crate::rotation::IDENTITY, scale);
    (filter, truth)
}

/// Goes on for 30 s from a true attitude, 20 s of them by hand. Returns the true attitude.
fn turn_by_hand(filter: &mut AttitudeFilter, mut truth: Quaternion<f32>, scale: &Matrix3<f32>) -> Quaternion<f32> {
    for k in 0..6_000_u16 {
        let t_s = f32::from(k.saturating_sub(2_000)) * 0.005;
        // Still for 10 s, then turned about all axes.
        let swing = |hertz: f32, most: f32| most * libm::sinf(core::f32::consts::TAU * hertz * t_s);
        let rate = Vector3::new(swing(0.31, 4.0), swing(0.23, 5.0), swing(0.41, 3.0));
        truth *= exp_quaternion(&(rate * 0.005));
        filter.propagate(0.005, &(scale * rate));
        let force = rotate_back(&truth, &Vector3::new(0.0, 0.0, -GRAVITY_M_S2));
        filter.observe(Some(&force), Some(&rotate_back(&truth, &Vector3::new(20.0, 0.0, 44.0))));
    }
    truth
}
