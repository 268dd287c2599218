//! A probe without a magnetometer, turned by hand between rests, with its accelerometer calibrated: no P
//! flies, and what flies does no harm. The truth is drawn at random.

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    compensation::GyroModel,
    config::Motion,
    identification::{Decision, Refusal, WindowReport},
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use testbed::flight::fly;

use crate::turntable::Random;

const STEP_S: f64 = 0.01;
const SAMPLES_PER_S: usize = 100;
const GRAVITY_M_S2: f64 = 9.806_65;
/// Seconds until the model is taken; the following constant those in which it is tried.
const SECONDS: usize = 205;
const LATER_SECONDS: usize = 120;
const SEEDS: u64 = 8;
/// Noise of a reading as of an MPU-9150 at 100 Hz: 0.005 deg/s and 400 ug per root hertz (PS sections 6.1 and
/// 6.2).
const GYRO_NOISE_RAD_S: f64 = 6e-4;
const ACCEL_NOISE_M_S2: f64 = 0.028;
/// Errors that a calibration leaves of the accelerometer's bias, a tenth of a mg, and of its scale.
const ACCEL_BIAS_M_S2: f64 = 1e-3;
const ACCEL_SCALE: f64 = 2e-4;
/// Acceleration by the hand while it turns the probe, m/s^2.
const HAND_M_S2: f64 = 1.0;

/// Errors beside that of P, one deviation of each element.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    /// G-sensitivity of the gyro, rad/s per g.
    g_sensitivity: f64,
    /// Half the difference of its scale from one sign to the other.
    asymmetry: f64,
    /// Term of the third order in the rate, per (rad/s)^2.
    nonlinearity: f64,
    lag_s: f64,
    /// rad/s per root second.
    bias_walk: f64,
    /// Errors of the accelerometer: zero-g offset, m/s^2, coupling, and the term of the second order, per g.
    accel_bias_m_s2: f64,
    accel_coupling: f64,
    accel_square: f64,
}

const NOTHING: Wrong = Wrong {
    g_sensitivity: 0.0,
    asymmetry: 0.0,
    nonlinearity: 0.0,
    lag_s: 0.0,
    bias_walk: 0.0,
    accel_bias_m_s2: 0.0,
    accel_coupling: 0.0,
    accel_square: 0.0,
};

/// As data sheets have them: 0.1 deg/s per g and 0.2 % (MPU-9150 PS section 6.1), 0.5 % of the accelerometer
/// (6.2); and a calibration of the accelerometer that is wrong by 0.3 deg.
const WRONG: [(&str, Wrong); 8] = [
    ("g-sensitivity", Wrong { g_sensitivity: 1.75e-3, ..NOTHING }),
    ("asymmetry", Wrong { asymmetry: 7e-3, ..NOTHING }),
    ("nonlinearity", Wrong { nonlinearity: 2e-3, ..NOTHING }),
    ("lag", Wrong { lag_s: 0.01, ..NOTHING }),
    ("bias walk", Wrong { bias_walk: 1e-4, ..NOTHING }),
    ("accelerometer's offset", Wrong { accel_bias_m_s2: 0.05, ..NOTHING }),
    ("accelerometer's coupling", Wrong { accel_coupling: 4e-3, ..NOTHING }),
    ("accelerometer's nonlinearity", Wrong { accel_square: 5e-3, ..NOTHING }),
];

struct Turned {
    samples: Vec<Sample>,
    attitudes: Vec<UnitQuaternion<f64>>,
    moving: Vec<bool>,
}

/// P is off by `sigma` on the diagonal and half of it beside it. Rests of three to five seconds, turns of two
/// to four about any axis.
fn turned(sigma: f64, wrong: &Wrong, seed: u64) -> Turned {
    let mut random = Random::new(seed);
    let p = Matrix3::from_fn(|i, j| if i == j { 1.0 + sigma * random.normal() } else { 0.5 * sigma * random.normal() });
    let inverse = p.try_inverse().unwrap();
    let mut bias = random.normal3() * 0.02;
    let accel_bias = random.normal3() * (ACCEL_BIAS_M_S2 + wrong.accel_bias_m_s2);
    let accel_scale = Matrix3::from_diagonal(&(random.normal3() * ACCEL_SCALE));
    let g_sensitivity = Matrix3::from_fn(|_, _| random.normal()) * (wrong.g_sensitivity / GRAVITY_M_S2);
    let (asymmetry, nonlinearity) = (random.normal3() * wrong.asymmetry, random.normal3() * wrong.nonlinearity);
    let coupling = Matrix3::from_fn(|_, _| random.normal()) * wrong.accel_coupling;
    let accel_matrix = Matrix3::identity() + accel_scale + (coupling + coupling.transpose()) * 0.5;
    let accel_square = random.normal3() * (wrong.accel_square / GRAVITY_M_S2);
    let mut attitude = random.attitude();
    let mut turned = Turned { samples: Vec::new(), attitudes: Vec::new(), moving: Vec::new() };
    let (mut left, mut length, mut moving) = (0_u32, 0_u32, true);
    let (mut turn, mut shake, mut lagged) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
    for k in 0..(SECONDS + LATER_SECONDS) * SAMPLES_PER_S {
        if left == 0 {
            moving = !moving;
            length = 100 * (if moving { 2 } else { 3 }) + (200.0 * random.uniform()) as u32;
            left = length;
            turn = random.normal3().normalize() * (0.8 + 2.2 * random.uniform());
            shake = random.normal3() * HAND_M_S2;
        }
        // A turn fades in and out, and so does the hand's acceleration, which goes nowhere.
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
        let force = attitude.inverse() * (Vector3::new(0.0, 0.0, -GRAVITY_M_S2) + shake * swing);
        let square = accel_square.component_mul(&force.component_mul(&force));
        let accel = accel_matrix * force + square + accel_bias + random.normal3() * ACCEL_NOISE_M_S2;
        lagged += (rate - lagged) * (STEP_S / (STEP_S + wrong.lag_s));
        let bent = lagged.zip_zip_map(&asymmetry, &nonlinearity, |w, a, n| w + a * w.abs() + n * w * w * w);
        bias += random.normal3() * (wrong.bias_walk * STEP_S.sqrt());
        let gyro = inverse * bent + bias + g_sensitivity * force + random.normal3() * GYRO_NOISE_RAD_S;
        turned.samples.push(Sample {
            t_us: 10_000 * (k as u64 + 1),
            gyro_rad_s: gyro.map(|x| x as f32).into(),
            accel_m_s2: accel.map(|x| x as f32).into(),
            flags: SampleFlags::MAG_MISSING | SampleFlags::TEMPERATURE_MISSING,
            ..Sample::default()
        });
        turned.attitudes.push(attitude);
        turned.moving.push(moving);
    }
    turned
}

impl Turned {
    /// Reports of the windows until the model is taken.
    fn reports(&self) -> Vec<WindowReport> {
        let mut config = Config { sample_period_us: 10_000, ..Config::default() };
        config.identification.motion = Motion::Hand;
        fly(&config, &self.samples[..SECONDS * SAMPLES_PER_S], |_| {}).unwrap().reports
    }

    /// Gravity carried by a model from the middle of each later rest to that of the next, against the truth,
    /// deg rms.
    fn carried_deg(&self, model: &GyroModel) -> f64 {
        let p = Matrix3::from_fn(|i, j| f64::from(model.p[i][j]));
        let bias = Vector3::from(model.b_rad_s).map(f64::from);
        let changes: Vec<usize> =
            (SECONDS * SAMPLES_PER_S..self.moving.len()).filter(|&k| self.moving[k] != self.moving[k - 1]).collect();
        let rests = changes.windows(2).filter(|ends| !self.moving[ends[0]]);
        let middles: Vec<usize> = rests.map(|ends| (ends[0] + ends[1]) / 2).collect();
        let down = |k: usize| self.attitudes[k].inverse() * Vector3::z();
        let square_deg = |ends: &[usize]| {
            let turn = (ends[0] + 1..=ends[1]).fold(UnitQuaternion::identity(), |turn, k| {
                let rate = p * (Vector3::from(self.samples[k].gyro_rad_s).map(f64::from) - bias);
                turn * UnitQuaternion::from_scaled_axis(rate * STEP_S)
            });
            (turn.inverse() * down(ends[0])).angle(&down(ends[1])).to_degrees().powi(2)
        };
        let squares: Vec<f64> = middles.windows(2).map(square_deg).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

/// Without a magnetometer rotation about gravity cannot be seen, so no P flies, and what flies carries
/// gravity as the bias alone does.
fn nothing_flies(sigma: f64, what: &str, wrong: &Wrong, seeds: u64) {
    for seed in 0..seeds {
        let turned = turned(sigma, wrong, seed);
        let reports = turned.reports();
        let last = reports.last().unwrap();
        let (flown, bias_only) = (turned.carried_deg(&last.flown), turned.carried_deg(&last.bias_only));
        println!("{what}, P off by {sigma}, seed {seed}: {flown:.3} deg, bias only {bias_only:.3} {:?}", last.decision);
        for report in &reports {
            let refused =
                matches!(report.decision, Decision::Refused(Refusal::NoMagnetometer { share }) if share > 0.99);
            assert!(refused && report.flown.p == GyroModel::IDENTITY.p, "{what} {sigma} {seed}: {report:?}");
        }
        assert!(flown <= 1.05 * bias_only + 0.02, "{what} {sigma} {seed}: {flown} {bias_only}");
    }
}

#[test]
fn without_a_magnetometer_no_p_flies_and_gravity_is_carried_as_with_the_bias_alone() {
    for sigma in [0.0, 0.02] {
        nothing_flies(sigma, "nothing else", &NOTHING, SEEDS);
    }
}

#[test]
fn nor_does_one_whatever_else_is_wrong() {
    for sigma in [0.0, 0.01, 0.02] {
        for (what, wrong) in &WRONG {
            nothing_flies(sigma, what, wrong, 2);
        }
    }
}
