//! A probe without a magnetometer that is turned by hand between rests, its accelerometer's calibration on record: pairs of rests judge P. The truth
//! is drawn at random.

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    compensation::GyroModel,
    identification::{Decision, WindowReport},
};
use mwd::{flight::fly, score::systematic_rate_error_rad_s};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::turntable::Random;

const STEP_S: f64 = 0.01;
const SECONDS: u32 = 205;
const SEEDS: u64 = 8;
/// Noise of a reading as of an MPU-9150 at 100 Hz: 0.005 deg/s and 400 ug per root hertz (PS sections 6.1 and 6.2).
const GYRO_NOISE_RAD_S: f64 = 6e-4;
const ACCEL_NOISE_M_S2: f64 = 0.028;
/// What a calibration leaves of the accelerometer's bias, a tenth of a mg, and of its scale.
const ACCEL_BIAS_M_S2: f64 = 1e-3;
const ACCEL_SCALE: f64 = 2e-4;
/// Of the hand, while it turns the probe.
const HAND_M_S2: f64 = 1.0;

struct Turned {
    samples: Vec<Sample>,
    rates: Vec<[f64; 3]>,
    gyro: GyroModel,
}

/// P is off by `sigma` on the diagonal and half of it beside it. Rests of three to five seconds, turns of two to four about any axis.
fn turned(sigma: f64, seed: u64) -> Turned {
    let mut random = Random::new(seed);
    let p = Matrix3::from_fn(|i, j| if i == j { 1.0 + sigma * random.normal() } else { 0.5 * sigma * random.normal() });
    let bias = random.normal3() * 0.02;
    let (accel_bias, accel_scale) = (random.normal3() * ACCEL_BIAS_M_S2, random.normal3() * ACCEL_SCALE);
    let inverse = p.try_inverse().unwrap();
    let mut attitude = random.attitude();
    let (mut samples, mut rates) = (Vec::new(), Vec::new());
    let (mut left, mut length, mut moving) = (0_u32, 0_u32, true);
    let (mut turn, mut shake) = (Vector3::zeros(), Vector3::zeros());
    for k in 0..SECONDS * 100 {
        if left == 0 {
            moving = !moving;
            length = 100 * (if moving { 2 } else { 3 }) + (200.0 * random.uniform()) as u32;
            left = length;
            turn = random.normal3().normalize() * (0.8 + 2.2 * random.uniform());
            shake = random.normal3() * HAND_M_S2;
        }
        // a turn fades in and out, and so does what the hand does, which goes nowhere
        let part = f64::from(length - left) / f64::from(length);
        let (fade, swing) = if moving {
            let sine = (std::f64::consts::PI * part).sin();
            (2.0 * sine * sine / (f64::from(length) * STEP_S), sine * (std::f64::consts::TAU * 2.0 * part).sin())
        } else {
            (0.0, 0.0)
        };
        left -= 1;
        let rate = turn * fade;
        attitude *= UnitQuaternion::from_scaled_axis(rate * STEP_S);
        let force = attitude.inverse() * (Vector3::new(0.0, 0.0, -9.806_65) + shake * swing);
        let accel = force + force.component_mul(&accel_scale) + accel_bias + random.normal3() * ACCEL_NOISE_M_S2;
        let gyro = inverse * rate + bias + random.normal3() * GYRO_NOISE_RAD_S;
        samples.push(Sample {
            t_us: 10_000 * u64::from(k + 1),
            gyro_rad_s: gyro.map(|x| x as f32).into(),
            accel_m_s2: accel.map(|x| x as f32).into(),
            flags: SampleFlags::MAG_MISSING | SampleFlags::TEMPERATURE_MISSING,
            ..Sample::default()
        });
        if moving {
            rates.push(rate.into());
        }
    }
    let gyro = GyroModel {
        p: std::array::from_fn(|i| std::array::from_fn(|j| p[(i, j)] as f32)),
        b_rad_s: bias.map(|x| x as f32).into(),
    };
    Turned { samples, rates, gyro }
}

fn reports(turned: &Turned) -> Vec<WindowReport> {
    let mut config = Config { sample_period_us: 10_000, ..Config::default() };
    // a calibration is on record
    config.accel.offset = [1e-6; 3];
    fly(&config, &turned.samples, |_| {}).unwrap().reports
}

#[test]
fn a_p_that_is_accepted_is_better_than_the_bias_alone_and_one_that_is_off_by_percents_is_accepted() {
    for (sigma, least, most) in [(0.0, 0, 0), (0.02, SEEDS as usize - 1, SEEDS as usize)] {
        let mut accepted = 0;
        for seed in 0..SEEDS {
            let turned = turned(sigma, seed);
            let reports = reports(&turned);
            let error = |model: &GyroModel| {
                systematic_rate_error_rad_s(&turned.gyro, model, &turned.rates).unwrap().to_degrees()
            };
            accepted += usize::from(reports.iter().any(|report| report.decision == Decision::Accepted));
            for report in reports.iter().filter(|report| report.decision == Decision::Accepted) {
                let (flown, bias_only) = (error(&report.flown), error(&report.bias_only));
                println!("off by {sigma}, seed {seed}: {flown:.3} deg/s, bias only {bias_only:.3}");
                assert!(flown < bias_only, "off by {sigma}, seed {seed}: {flown} against {bias_only}");
            }
        }
        println!("off by {sigma}: accepted in {accepted} of {SEEDS}");
        assert!((least..=most).contains(&accepted), "off by {sigma}: {accepted}");
    }
}
