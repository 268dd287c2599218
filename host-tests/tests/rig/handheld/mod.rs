//! Motion by hand with known truth, and sensors with every error that factory-calibrated units have shown,
//! drawn at random. Its purpose is what the identification's model does not hold.

mod random;

use meerkat_mwd::{Sample, SampleFlags, compensation::GyroModel};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
pub use random::Random;
use std::f64::consts::TAU;
use testbed::trace::{BodyFrame, EarthFrame, Keys, Trace};

const PERIOD_US: u64 = 3500;
/// Truth is integrated at four steps a sample.
const STEP_S: f64 = 0.25 * 3.5e-3;
const GRAVITY_M_S2: f64 = 9.81;

/// A sum of sines, root mean square 1.
struct Multisine(Vec<[f64; 3]>);

impl Multisine {
    fn new(random: &mut Random, lowest_hz: f64, highest_hz: f64) -> Self {
        let count = 7;
        let amplitude = (2.0 / f64::from(count)).sqrt();
        Self(
            (0..count)
                .map(|_| [amplitude, TAU * random.between(lowest_hz, highest_hz), random.between(0.0, TAU)])
                .collect(),
        )
    }
    fn at(&self, t: f64) -> f64 {
        self.0.iter().map(|[a, w, phase]| a * (w * t + phase).sin()).sum()
    }
    fn second_derivative(&self, t: f64) -> f64 {
        self.0.iter().map(|[a, w, phase]| -a * w * w * (w * t + phase).sin()).sum()
    }
}

/// Kind of recording; everything else is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Rotation,
    Translation,
    Both,
    Breaks,
    Tapping,
    Vibration,
    MagnetAttached,
    MagnetNearby,
}

pub const KINDS: [Kind; 8] = [
    Kind::Rotation,
    Kind::Translation,
    Kind::Both,
    Kind::Breaks,
    Kind::Tapping,
    Kind::Vibration,
    Kind::MagnetAttached,
    Kind::MagnetNearby,
];

/// Size of the gyro's error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GyroError {
    /// Every element of P within 0.7 % of the identity's.
    Factory,
    /// Diagonal within this share, the others within half of it, on top of that.
    Percent(f64),
}

/// A recording of `length_s` by hand; `fast` as a child shakes it, otherwise as one looks at it.
pub fn record(kind: Kind, fast: bool, error: GyroError, length_s: f64, seed: u64) -> (Trace, GyroModel) {
    let random = &mut Random::new(seed);

    // Motion.
    let begins_s = if random.chance(0.85) { random.between(5.0, 12.0) } else { -1.0 };
    let with_breaks = kind == Kind::Breaks || random.chance(0.15);
    let break_sine = Multisine::new(random, 0.03, 0.12);
    let envelope = |t: f64| {
        let begun = ((t - begins_s) / 1.5).clamp(0.0, 1.0);
        let run = if with_breaks { (2.0 * break_sine.at(t) + 0.8).clamp(0.0, 1.0) } else { 1.0 };
        let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
        smooth(begun) * smooth(run)
    };
    let rotation_rms = match kind {
        Kind::Translation => random.between(0.05, 0.4),
        _ if fast => random.between(2.0, 4.5),
        _ => random.between(0.4, 1.5),
    };
    let highest_hz = if fast { random.between(0.8, 1.8) } else { random.between(0.25, 0.8) };
    let turning = [0; 3].map(|_| Multisine::new(random, 0.05, highest_hz));
    let loudness = [0; 3].map(|_| Multisine::new(random, 0.02, 0.1));
    // A hand prefers an axis.
    let preference = random.rotation()
        * Matrix3::from_diagonal(&Vector3::new(1.0, random.between(0.15, 1.0), random.between(0.15, 1.0)));
    let rate_at = |t: f64| {
        let each = |i: usize| turning[i].at(t) * (1.0 + 0.7 * loudness[i].at(t));
        preference * Vector3::new(each(0), each(1), each(2)) * (rotation_rms * envelope(t) / 1.4)
    };
    let acceleration_rms = match (kind, fast) {
        (Kind::Rotation, _) => random.between(0.0, 0.5),
        (_, false) => random.between(0.2, 2.0),
        (_, true) => random.between(2.0, 7.0),
    };
    let (translation_low, translation_high) = if fast { (0.5, 2.0) } else { (0.15, 0.7) };
    let path = [0; 3].map(|_| Multisine::new(random, translation_low, translation_high));
    // Root mean square acceleration of the path at amplitude 1.
    let unit = (0..400).map(|k| path[0].second_derivative(0.37 * f64::from(k)).powi(2)).sum::<f64>() / 400.0;
    let path_size = acceleration_rms / unit.sqrt();
    // The hand turns about a pivot some way off: wrist, elbow or the palm itself.
    let pivot = random.direction() * random.between(0.02, 0.4_f64.min(6.0 / rotation_rms.powi(2)).max(0.03));
    let lever_arm = random.direction() * random.between(0.005, 0.015);

    // World.
    let field = Vector3::new(19.0, 0.0, 45.0) * random.between(0.9, 1.1);
    let gradient_size = match kind {
        Kind::MagnetNearby => random.between(4.0, 25.0),
        _ if random.chance(0.3) => random.between(2.0, 8.0),
        _ => random.between(0.0, 2.0),
    };
    let gradient = {
        let any = random.matrix(1.0);
        let symmetric = any + any.transpose();
        let traceless = symmetric - Matrix3::identity() * (symmetric.trace() / 3.0);
        traceless * (gradient_size / traceless.norm() * 1.4)
    };

    // Truth on a fine grid.
    let count = (length_s / STEP_S) as usize;
    let mut attitude = UnitQuaternion::from_rotation_matrix(&random.rotation());
    let (mut rates, mut attitudes) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut forces, mut fields) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for k in 0..count {
        let t = k as f64 * STEP_S;
        let rate = rate_at(t);
        let spin_up = (rate_at(t + 1e-3) - rate_at(t - 1e-3)) / 2e-3;
        let arm = pivot + lever_arm;
        let envelope = envelope(t);
        let acceleration = Vector3::from_fn(|i, _| path[i].second_derivative(t)) * (path_size * envelope);
        let position = Vector3::from_fn(|i, _| path[i].at(t)) * (path_size * envelope) + attitude * pivot;
        let force = attitude.inverse() * (acceleration - Vector3::new(0.0, 0.0, GRAVITY_M_S2))
            + spin_up.cross(&arm)
            + rate.cross(&rate.cross(&arm));
        rates.push(rate);
        attitudes.push(attitude);
        forces.push(force);
        fields.push(attitude.inverse() * (field + gradient * position));
        attitude *= UnitQuaternion::from_scaled_axis(rate_at(t + 0.5 * STEP_S) * STEP_S);
    }

    // Sensors.
    let factory = Matrix3::identity() + random.matrix(0.007);
    let p = match error {
        GyroError::Factory => factory,
        GyroError::Percent(size) => {
            let extra = Matrix3::from_fn(|i, j| {
                let largest = if i == j { size } else { 0.5 * size };
                random.between(0.5 * largest, largest) * if random.chance(0.5) { 1.0 } else { -1.0 }
            });
            factory * (Matrix3::identity() + extra)
        }
    };
    let p_inverse = p.try_inverse().unwrap();
    let bias = random.direction() * random.between(0.1, 1.0_f64).to_radians();
    let bias_walk = random.between(0.0, 1e-4);
    let largest_g_sensitivity = if random.chance(0.3) { 1.5e-4 } else { 2e-5 };
    let g_sensitivity = random.matrix(largest_g_sensitivity);
    let mag_matrix = Matrix3::identity() + random.matrix(random_size(kind));
    let iron = random.direction() * random.between(0.2, 3.0);
    let magnet = match kind {
        Kind::MagnetAttached => random.direction() * random.between(4.0, 27.0),
        _ => Vector3::zeros(),
    };
    let (magnet_on_s, magnet_off_s) = {
        let on = random.between(0.0, 0.6 * length_s);
        (on, on + random.between(10.0, length_s))
    };
    let mag_lag_s = random.between(0.0, 0.020);
    let accel_lag_s = random.between(-0.004, 0.004);
    let accel_matrix = Matrix3::identity() + random.matrix(0.006);
    let accel_bias = random.direction() * random.between(0.0, 0.15);
    let slow_mag = random.chance(0.5);
    let vibration = match kind {
        Kind::Vibration => (random.direction() * random.between(1.0, 8.0), random.between(130.0, 210.0)),
        _ => (Vector3::zeros(), 150.0),
    };
    let gyro_vibration = vibration.0 * random.between(0.0, 0.03);
    let taps: Vec<(f64, Vector3<f64>)> = match kind {
        Kind::Tapping => {
            let mut t = 2.0;
            let mut taps = Vec::new();
            while t < length_s {
                t += random.between(0.3, 3.0);
                taps.push((t, random.direction() * random.between(10.0, 100.0)));
            }
            taps
        }
        _ => Vec::new(),
    };

    let mean = |values: &[Vector3<f64>], t: f64| {
        let centre = (t / STEP_S).round().max(0.0) as usize;
        let (from, to) = (centre.saturating_sub(2), (centre + 2).min(values.len() - 1));
        values[from.min(to)..=to].iter().sum::<Vector3<f64>>() / ((to - from.min(to) + 1) as f64)
    };
    let mut trace = Trace {
        keys: Keys { earth_frame: EarthFrame::Ned, body_frame: BodyFrame::Sensor, ..Keys::default() },
        ..Trace::default()
    };
    let mut movement = Vec::new();
    let mut drift = Vector3::zeros();
    let mut mag_ticks = [(f64::NEG_INFINITY, Vector3::zeros()); 2];
    let samples = (count / 4).saturating_sub(4);
    for k in 4..samples {
        let t = k as f64 * 4.0 * STEP_S;
        let shaken: Vector3<f64> = taps
            .iter()
            .filter(|(at, _)| (0.0..0.08).contains(&(t - at)))
            .map(|(at, size)| size * ((-(t - at) / 0.012).exp() * (TAU * 90.0 * (t - at)).sin()))
            .sum();
        let tone = (TAU * vibration.1 * t).sin();
        let force = mean(&forces, t - accel_lag_s) + vibration.0 * tone + shaken;
        drift += random.normal3() * (bias_walk * (4.0 * STEP_S).sqrt());
        let gyro = p_inverse * mean(&rates, t)
            + bias
            + drift
            + g_sensitivity * force
            + gyro_vibration * tone
            + shaken * 0.01
            + random.normal3() * 0.003;
        let accel = accel_matrix * force + accel_bias + random.normal3() * 0.06;
        let attached = if (magnet_on_s..magnet_off_s).contains(&t) { magnet } else { Vector3::zeros() };
        let noise = random.normal3() * 0.4;
        let read_mag = |t: f64| mag_matrix * mean(&fields, t - mag_lag_s) + iron + attached + noise;
        let mag = if slow_mag {
            // Read at 95 Hz and interpolated by the host.
            if t >= mag_ticks[1].0 {
                let tick = mag_ticks[1].0.max(t - 0.0105) + 0.0105;
                mag_ticks = [mag_ticks[1], (tick, read_mag(tick))];
            }
            let [(t0, m0), (t1, m1)] = mag_ticks;
            if t0.is_finite() { m0 + (m1 - m0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0) } else { m1 }
        } else {
            read_mag(t)
        };
        let single = |v: Vector3<f64>| <[f64; 3]>::from(v).map(|x| x as f32);
        trace.samples.push(Sample {
            t_us: k as u64 * PERIOD_US,
            gyro_rad_s: single(gyro),
            accel_m_s2: single(accel),
            mag_ut: single(mag),
            flags: SampleFlags::TEMPERATURE_MISSING,
            ..Sample::default()
        });
        let q = attitudes[4 * k];
        trace.reference.push(Some([q.w, q.i, q.j, q.k]));
        movement.push(t > begins_s);
    }
    trace.movement = Some(movement);
    let truth = GyroModel {
        p: std::array::from_fn(|i| std::array::from_fn(|j| p[(i, j)] as f32)),
        b_rad_s: <[f64; 3]>::from(bias).map(|x| x as f32),
    };
    (trace, truth)
}

/// Largest element of the magnetometer's misalignment and soft iron.
fn random_size(_: Kind) -> f64 {
    0.03
}
