//! Turns too slow for the gyro, biases that step at rest, and a magnet that comes near.

use crate::{Config, attitude::AttitudeFilter, rotation::exp_matrix};
use nalgebra::{Matrix3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const PERIOD_S: f32 = 0.01;

/// Largest heading error, rad, and its share of the stated deviation, of a probe that stands at 45 deg, turns about
/// the vertical at `rate_rad_s` from 10 to 29 s, and stands again; `disturbed` gives the field at a time, seconds.
fn worst(seed: u64, rate_rad_s: f32, disturbed: impl Fn(f32, Vector3<f32>) -> Vector3<f32>) -> (f32, f32) {
    let (largest, share, _) = flown(seed, rate_rad_s, 0.0, 1, disturbed);
    (largest, share)
}

/// The same, with a bias about the vertical that steps at 30 s, rad/s, and a field in every sample of this number; and
/// the heading error at the end, rad.
fn flown(
    seed: u64,
    rate_rad_s: f32,
    step_rad_s: f32,
    every: u16,
    disturbed: impl Fn(f32, Vector3<f32>) -> Vector3<f32>,
) -> (f32, f32, f32) {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut uniform = || random.next_u32() as f32 / u32::MAX as f32 * 2.0 - 1.0;
    let mut vector = |size: f32| Vector3::new(uniform(), uniform(), uniform()) * (size * libm::sqrtf(3.0));
    let (config, mut filter) = (Config::default(), AttitudeFilter::new());
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    let bias = vector(3e-3);
    let tilt = exp_matrix(&Vector3::new(0.3, 0.7, -0.2));
    let (mut largest, mut share, mut turned, mut last) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    for k in 0..10_000_u16 {
        let t = f32::from(k) * PERIOD_S;
        let turning = if (10.0..29.0).contains(&t) { rate_rad_s } else { 0.0 };
        turned += turning * PERIOD_S;
        let body_to_ned: Matrix3<f32> = exp_matrix(&Vector3::new(0.0, 0.0, turned)) * tilt;
        let in_body = |v: Vector3<f32>| body_to_ned.transpose() * v;
        let stepped = if t > 30.0 { step_rad_s } else { 0.0 };
        let rate = bias + in_body(Vector3::new(0.0, 0.0, turning + stepped)) + vector(2e-3);
        filter.propagate(PERIOD_S, &rate);
        let field = in_body(disturbed(t, Vector3::new(25.0, 0.0, 43.0))) + vector(0.15);
        let field = (k % every == 0).then_some(field);
        filter.observe(Some(&(in_body(Vector3::new(0.0, 0.0, -9.81)) + vector(0.02))), field.as_ref());
        if t > 5.0 {
            let attitude = filter.attitude(crate::attitude::AttitudeFlags::empty()).unwrap();
            let truth = libm::atan2f(body_to_ned[(1, 2)], body_to_ned[(0, 2)]);
            let error = libm::fabsf(libm::remainderf(attitude.azimuth_rad - truth, core::f32::consts::TAU));
            let part = error / attitude.sigma_azimuth_rad;
            largest = if error > largest { error } else { largest };
            share = if part > share { part } else { share };
            last = error;
        }
    }
    (largest, share, last)
}

#[test]
fn a_string_that_untwists_slowly_is_followed() {
    for seed in 0..4 {
        for deg_s in [0.05_f32, 0.1, 0.2, 0.3] {
            let (error, share) = worst(seed, deg_s.to_radians(), |_, field| field);
            assert!(error < 0.6_f32.to_radians(), "seed {seed}, {deg_s} deg/s: {} deg", error.to_degrees());
            assert!(share < 1.0, "seed {seed}, {deg_s} deg/s: {share} of its deviation");
        }
    }
}

/// At 100 Hz, a magnetometer of 10 and of 5 Hz.
#[test]
fn a_field_that_is_read_less_often_shows_a_turn_of_the_same_rate() {
    for every in [10, 20] {
        for seed in 0..4 {
            for deg_s in [0.1_f32, 0.2, 0.3] {
                let (error, share, last) = flown(seed, deg_s.to_radians(), 0.0, every, |_, field| field);
                let text = [error, last].map(f32::to_degrees);
                assert!(error < 1.0_f32.to_radians(), "every {every}, seed {seed}, {deg_s} deg/s: {text:?} {share}");
                assert!(share < 1.0, "every {every}, seed {seed}, {deg_s} deg/s: {text:?} {share}");
            }
        }
    }
}

#[test]
fn a_bias_that_steps_at_rest_is_a_turn_until_the_field_has_had_time_to_show_that_it_is_none() {
    for seed in 0..4 {
        for deg_s in [0.1_f32, -0.2] {
            let (error, share, last) = flown(seed, 0.0, deg_s.to_radians(), 1, |_, field| field);
            assert!(share < 1.5 && last < 1.0_f32.to_radians(), "seed {seed}, {deg_s} deg/s: {error} {share} {last}");
        }
    }
}

#[test]
fn what_comes_near_a_probe_that_stands_turns_nothing() {
    for seed in 0..4 {
        let magnet = |t: f32, field: Vector3<f32>| {
            if (20.0..40.0).contains(&t) { field + Vector3::new(1.0, 2.0, 4.0) } else { field }
        };
        let (still, _) = worst(seed, 0.0, |_, field| field);
        let (error, share) = worst(seed, 0.0, magnet);
        assert!(error < still + 1.0_f32.to_radians() && share < 1.0, "seed {seed}: {still} {error} {share}");
    }
}
