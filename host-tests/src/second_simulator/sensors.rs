//! Three sensors with errors within their data sheets, and the effect that a case adds.

use super::{STEP_S, STEPS_HZ};
use meerkat_mwd::{Sample, SampleFlags};
use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;
use testbed::simulate::Random;

/// Effects that nobody declares, each off at 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct Added {
    /// Delays, seconds.
    pub gyro_lag_s: f64,
    /// Delay of the magnetometer.
    pub mag_lag_s: f64,
    /// Delay of the accelerometer.
    pub accel_lag_s: f64,
    /// True for low-passes of the first order in the place of pure delays.
    pub low_pass: bool,
    /// The field lags by this time with the rotation about the tool axis, seconds.
    pub eddy_lag_s: f64,
    /// From the axis of rotation to the accelerometer, body axes.
    pub lever_arm_m: [f64; 3],
    /// Rate per specific force, rad/s per m/s^2.
    pub g_sensitivity_s_m: [[f64; 3]; 3],
    /// Rate per squared acceleration, rad/s per (m/s^2)^2.
    pub rectification_s3_m2: [f64; 3],
    /// Cube of the rate, s^2/rad^2.
    pub nonlinearity_s2_rad2: [f64; 3],
    /// Amount of the rate.
    pub asymmetry: [f64; 3],
    /// Bias per warming, rad/s per kelvin.
    pub bias_per_k: [f64; 3],
    /// Scale per warming, 1/K.
    pub scale_per_k: [f64; 3],
    /// Change of the bias, rad/s.
    pub bias_step_rad_s: [f64; 3],
    /// When it comes, seconds.
    pub bias_step_at_s: f64,
    /// Field that turns with the body, microtesla.
    pub hard_iron_ut: [f64; 3],
    /// Field that iron adds, as a share of the field.
    pub soft_iron: [[f64; 3]; 3],
    /// Bias, m/s^2.
    pub accel_bias_m_s2: [f64; 3],
    /// Bias per warming, m/s^2 per kelvin.
    pub accel_bias_per_k: [f64; 3],
    /// Offset per warming, microtesla per kelvin.
    pub mag_offset_per_k: [f64; 3],
}

/// Quantities that the sensors feel in one step, body axes.
pub(super) struct Moment {
    pub t_s: f64,
    pub warmer_k: f64,
    pub rate_rad_s: Vector3<f64>,
    pub accelerated_m_s2: Vector3<f64>,
    pub force_m_s2: Vector3<f64>,
    pub field_ut: Vector3<f64>,
}

/// A pure delay, or a low-pass of the first order with the same delay of what is slow.
struct Late {
    steps: usize,
    smoothing: Option<f64>,
    past: VecDeque<Vector3<f64>>,
}

impl Late {
    fn new(lag_s: f64, low_pass: bool) -> Self {
        let smoothing = (low_pass && lag_s > 0.0).then(|| 1.0 - (-STEP_S / lag_s).exp());
        Self { steps: (lag_s * f64::from(STEPS_HZ)).round() as usize, smoothing, past: VecDeque::new() }
    }

    fn next(&mut self, value: Vector3<f64>) -> Vector3<f64> {
        if let Some(smoothing) = self.smoothing {
            let last = self.past.pop_front().unwrap_or(value);
            let next = last + (value - last) * smoothing;
            self.past.push_back(next);
            return next;
        }
        self.past.push_back(value);
        if self.past.len() > self.steps + 1 {
            self.past.pop_front();
        }
        self.past.front().copied().unwrap_or(value)
    }
}

/// The sensors of one run.
pub struct Sensors {
    added: Added,
    p_inverse: Matrix3<f64>,
    bias_rad_s: Vector3<f64>,
    /// Slow wander of the bias (flicker noise's stand-in), rad/s.
    wander_rad_s: Vector3<f64>,
    accel: (Matrix3<f64>, Vector3<f64>),
    mag: (Matrix3<f64>, Vector3<f64>),
    late: [Late; 3],
    sums: [Vector3<f64>; 3],
    noise: Random,
}

/// Data-sheet class of the parts: noise of one sample at 100 Hz and resolution.
const GYRO_NOISE_RAD_S: f64 = 6.0e-4;
const GYRO_STEP_RAD_S: f64 = 3.05e-4;
const ACCEL_NOISE_M_S2: f64 = 0.01;
const ACCEL_STEP_M_S2: f64 = 4.8e-3;
const MAG_NOISE_UT: f64 = 0.05;
const MAG_STEP_UT: f64 = 0.013;
/// Wander of the bias: deviation and time constant.
const WANDER_RAD_S: f64 = 3.5e-5;
const WANDER_S: f64 = 100.0;

impl Sensors {
    pub(super) fn new(added: &Added, drawn: &mut Random, noise: Random) -> Self {
        let mut matrix = |scale: f64, cross: f64| {
            Matrix3::from_fn(|i, j| if i == j { 1.0 + scale * drawn.normal() } else { cross * drawn.normal() })
        };
        let p_inverse = matrix(0.015, 0.01);
        let (accel, mag) = (matrix(1e-3, 1e-3), matrix(1.5e-3, 1.5e-3));
        let mut vector = |deviation: f64| drawn.normal3() * deviation;
        Self {
            added: *added,
            p_inverse,
            bias_rad_s: vector(0.4_f64.to_radians()),
            wander_rad_s: Vector3::zeros(),
            accel: (accel, vector(4e-3)),
            mag: (mag, vector(0.05)),
            late: [added.gyro_lag_s, added.accel_lag_s, added.mag_lag_s].map(|lag| Late::new(lag, added.low_pass)),
            sums: [Vector3::zeros(); 3],
            noise,
        }
    }

    pub(super) fn step(&mut self, moment: &Moment) {
        let of = |rows: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| rows[i][j]);
        let added = &self.added;
        let [gyro, accel, mag] = &mut self.late;
        let rate = self.p_inverse * gyro.next(moment.rate_rad_s);
        let bent = Vector3::from_fn(|i, _| {
            let (u, k) = (rate[i], moment.warmer_k);
            u + added.nonlinearity_s2_rad2[i] * u.powi(3)
                + added.asymmetry[i] * u.abs()
                + added.scale_per_k[i] * k * u
                + added.bias_per_k[i] * k
        });
        let stepped = if moment.t_s >= added.bias_step_at_s { 1.0 } else { 0.0 };
        let [sum_rate, sum_force, sum_field] = &mut self.sums;
        *sum_rate += bent
            + of(&added.g_sensitivity_s_m) * moment.force_m_s2
            + Vector3::from(added.rectification_s3_m2) * moment.accelerated_m_s2.norm_squared()
            + Vector3::from(added.bias_step_rad_s) * stepped;
        let biased = Vector3::from(added.accel_bias_m_s2) + Vector3::from(added.accel_bias_per_k) * moment.warmer_k;
        *sum_force += accel.next(moment.force_m_s2) + biased;
        let eddy = Vector3::z().cross(&moment.field_ut) * (added.eddy_lag_s * moment.rate_rad_s.z);
        let field = mag.next(moment.field_ut + eddy);
        let iron = Vector3::from(added.hard_iron_ut) + Vector3::from(added.mag_offset_per_k) * moment.warmer_k;
        *sum_field += field + of(&added.soft_iron) * field + iron;
    }

    /// The readings since the last ones.
    pub(super) fn read(&mut self, t_us: u64, steps: u32, temperature_c: Option<f64>) -> Sample {
        let [rate, force, field] = self.sums.map(|sum| sum / f64::from(steps));
        self.sums = [Vector3::zeros(); 3];
        let seconds = f64::from(steps) * STEP_S;
        let kept = (-seconds / WANDER_S).exp();
        self.wander_rad_s =
            self.wander_rad_s * kept + self.noise.normal3() * (WANDER_RAD_S * (1.0 - kept * kept).sqrt());
        // Noise of a rate of samples other than 100 Hz.
        let louder = (0.01 / seconds).sqrt();
        let mut read = |value: Vector3<f64>, deviation: f64, step: f64| -> [f32; 3] {
            let noisy = value + self.noise.normal3() * deviation;
            [noisy.x, noisy.y, noisy.z].map(|x| (step * (x / step).round()) as f32)
        };
        let gyro = read(rate + self.bias_rad_s + self.wander_rad_s, GYRO_NOISE_RAD_S * louder, GYRO_STEP_RAD_S);
        let accel = read(self.accel.0 * force + self.accel.1, ACCEL_NOISE_M_S2 * louder, ACCEL_STEP_M_S2);
        let mag = read(self.mag.0 * field + self.mag.1, MAG_NOISE_UT, MAG_STEP_UT);
        Sample {
            t_us,
            gyro_rad_s: gyro,
            accel_m_s2: accel,
            mag_ut: mag,
            temperature_c: temperature_c.map_or(0.0, |x| x as f32),
            flags: if temperature_c.is_some() { SampleFlags::empty() } else { SampleFlags::TEMPERATURE_MISSING },
        }
    }
}
