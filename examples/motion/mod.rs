//! A probe that rests and is then turned and carried about by hand: samples of a gyro with known errors.

use meerkat_mwd::{Config, Sample, SampleFlags, compensation::GyroModel, config::Motion};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Sample period, microseconds.
const PERIOD_US: u32 = 10_000;
/// Rest before the motion, seconds.
const REST_S: f32 = 8.0;
/// Earth's field in the north-east-down frame, microtesla.
const FIELD_UT: [f32; 3] = [20.0, 0.0, 44.0];
/// Specific force at rest in the same frame, m/s^2.
const FORCE_M_S2: [f32; 3] = [0.0, 0.0, -9.806_65];
/// Deviations of a gyro's, an accelerometer's and a magnetometer's noise: rad/s, m/s^2, microtesla.
const NOISE: [f32; 3] = [2e-3, 0.02, 0.15];

/// Errors of the simulated gyro: its reading is P^-1 w + b.
pub(crate) const TRUE: GyroModel =
    GyroModel { p: [[1.06, 0.02, -0.01], [-0.02, 0.95, 0.03], [0.01, -0.03, 1.04]], b_rad_s: [0.02, -0.015, 0.01] };

/// Configuration of the probe: what nobody would have to learn.
pub(crate) fn config() -> Config {
    let mut config = Config { sample_period_us: PERIOD_US, ..Config::default() };
    config.identification.motion = Motion::Hand;
    config
}

/// Samples of `seconds` of motion; `further` is read by the gyro beside its errors, rad/s, at a body rate.
pub(crate) fn samples(seconds: f32, further: fn(Vector3<f32>) -> Vector3<f32>) -> impl Iterator<Item = Sample> {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
    let mut noise = move |sigma: f32| {
        // Twelve uniform deviates of variance 1/12.
        Vector3::from_fn(|_, _| (0..12).map(|_| generator.next_u32() as f32 / u32::MAX as f32 - 0.5).sum::<f32>())
            * sigma
    };
    let inverse = Matrix3::from_fn(|i, j| TRUE.p[i][j]).try_inverse().unwrap_or_else(Matrix3::identity);
    let bias = Vector3::from(TRUE.b_rad_s);
    let mut to_earth = Rotation3::identity();
    let period_s = PERIOD_US as f32 * 1e-6;
    (1..=(seconds / period_s) as u32).map(move |k| {
        let t_s = k as f32 * period_s;
        let moving = if t_s > REST_S { libm::fminf(0.5 * (t_s - REST_S), 1.0) } else { 0.0 };
        let swing = |rad_s: f32, hz: f32, phase: f32| {
            moving * rad_s * libm::sinf(core::f32::consts::TAU * hz * (t_s - 0.5 * period_s) + phase)
        };
        // Slow and fast swing of each axis, so that the probe turns about all directions.
        let rate = Vector3::new(
            swing(2.0, 0.31, 0.3) + swing(1.2, 0.73, 1.9),
            swing(1.7, 0.43, 2.1) + swing(1.4, 0.67, 0.4),
            swing(2.2, 0.37, 4.0) + swing(1.1, 0.59, 2.8),
        );
        to_earth *= Rotation3::from_scaled_axis(rate * period_s);
        let accelerated = Vector3::new(swing(0.6, 0.9, 0.0), swing(0.5, 1.1, 1.0), swing(0.4, 0.7, 2.0));
        let [gyro, accel, mag] = NOISE.map(&mut noise);
        Sample {
            t_us: u64::from(k) * u64::from(PERIOD_US),
            gyro_rad_s: (inverse * rate + bias + further(rate) + gyro).into(),
            accel_m_s2: (to_earth.inverse() * (Vector3::from(FORCE_M_S2) + accelerated) + accel).into(),
            mag_ut: (to_earth.inverse() * Vector3::from(FIELD_UT) + mag).into(),
            temperature_c: 0.0,
            flags: SampleFlags::TEMPERATURE_MISSING,
        }
    })
}
