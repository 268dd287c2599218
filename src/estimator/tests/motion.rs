//! A sensor unit at rest, then turned and carried about by hand, with a gyro that is off.

use super::std::vec::Vec;
use crate::{compensation::GyroModel, sample::Reading};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const PERIOD_S: f64 = 0.01;
const REST_S: f64 = 6.0;

pub struct Simulated {
    pub samples: Vec<(u64, [Reading; 3])>,
    /// Body to an earth frame whose y points to magnetic north and z up, at each sample.
    pub attitudes: Vec<Rotation3<f64>>,
    pub truth: GyroModel,
}

struct Random(Xoshiro128PlusPlus);

impl Random {
    fn uniform(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    /// Deviate of unit variance, near enough to normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() * 0.5
    }

    fn vector(&mut self, sigma: f64) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}

impl Simulated {
    pub fn new(seed: u64, seconds: f64) -> Self {
        let mut random = Random(Xoshiro128PlusPlus::seed_from_u64(seed + 1));
        // Off centre: no element is near the factory's.
        let p = Matrix3::from_fn(|i, j| {
            let size = if i == j { 0.05 } else { 0.025 };
            let off = random.uniform() * size;
            f64::from(u8::from(i == j)) + off + 0.5 * size.copysign(off)
        });
        let bias = random.vector(0.01);
        let (inverse, mut attitude) = (p.try_inverse().unwrap(), Rotation3::identity());
        let mag = Matrix3::identity() + Matrix3::from_fn(|_, _| random.normal() * 0.005);
        let (iron, field) = (random.vector(1.0), Vector3::new(0.0, 20.0, -44.0));
        // Five sines an axis, of rate and of place.
        let sines: [[[f64; 3]; 5]; 6] = core::array::from_fn(|axis| {
            core::array::from_fn(|_| {
                let size = if axis < 3 { 1.0 } else { 0.06 };
                [0.3 + 0.4 * random.uniform().abs(), size * (0.6 + 0.4 * random.uniform()), 3.0 * random.uniform()]
            })
        });
        let swing = |axis: usize, t: f64, derivative: u8| -> f64 {
            sines[axis].iter().fold(0.0, |sum, [hz, size, phase]| {
                let w = 2.0 * core::f64::consts::PI * hz;
                sum + match derivative {
                    0 => size * libm::sin(w * t + phase),
                    _ => -size * w * w * libm::sin(w * t + phase),
                }
            })
        };
        let (mut samples, mut attitudes) = (Vec::new(), Vec::new());
        for k in 0..(seconds / PERIOD_S) as u64 {
            let t = k as f64 * PERIOD_S;
            let moving = if t > REST_S { 1.0_f64.min((t - REST_S) / 2.0) } else { 0.0 };
            // The mean over the interval that the sample ends.
            let middle = t - 0.5 * PERIOD_S;
            let rate = Vector3::from_fn(|axis, _| moving * swing(axis, middle, 0));
            attitude *= Rotation3::from_scaled_axis(rate * PERIOD_S);
            let acceleration = Vector3::from_fn(|axis, _| moving * swing(axis + 3, t, 2));
            let force = attitude.inverse() * (acceleration + Vector3::new(0.0, 0.0, 9.806_65));
            let read = mag * (attitude.inverse() * field) + iron;
            let raw = inverse * rate + bias + random.vector(2e-3);
            let readings = [raw, force + random.vector(0.02), read + random.vector(0.15)];
            attitudes.push(attitude);
            samples.push((k * 10_000, readings.map(|v| Reading::Usable(v.cast::<f32>()))));
        }
        let p = p.map(|x| x as f32);
        let truth = GyroModel {
            p: core::array::from_fn(|i| core::array::from_fn(|j| p[(i, j)])),
            b_rad_s: bias.cast::<f32>().into(),
        };
        Self { samples, attitudes, truth }
    }
}

/// A probe in a drill string: it rests, then it turns at a steady rate about the axis that its body's x has at first,
/// rad/s, from `from_s` on; gravity and field with their noise.
pub fn drill_string(seed: u64, seconds: f64, from_s: f64, rate: f64) -> Vec<(u64, [Reading; 3])> {
    let mut random = Random(Xoshiro128PlusPlus::seed_from_u64(seed + 1));
    let (bias, tilt) = (random.vector(2e-3), random.vector(0.8));
    let (gravity, field) = (Vector3::new(0.0, 0.0, 9.806_65), Vector3::new(0.0, 20.0, -44.0));
    let sample = |k: u64| {
        let t = k as f64 * PERIOD_S;
        let turned = Vector3::x() * (rate * (t - from_s).max(0.0));
        let attitude = Rotation3::from_scaled_axis(tilt) * Rotation3::from_scaled_axis(turned);
        let raw = bias + if t > from_s { Vector3::x() * rate } else { Vector3::zeros() };
        let vectors = [gravity, field].map(|v| attitude.inverse() * v);
        let [force, read] = vectors;
        let readings = [raw + random.vector(2e-3), force + random.vector(0.02), read + random.vector(0.15)];
        (k * 10_000, readings.map(|v| Reading::Usable(v.cast::<f32>())))
    };
    (0..(seconds / PERIOD_S) as u64).map(sample).collect()
}

/// A probe in a drill string that turns about its axis, z, in stretches of 12 s with stops of 5 s; the axis swings by
/// so much, rad, in a minute, and so many microtesla lie along it.
pub fn swinging_string(seed: u64, seconds: f64, swing_rad: f64, axial_ut: f64) -> Vec<(u64, [Reading; 3])> {
    let mut random = Random(Xoshiro128PlusPlus::seed_from_u64(seed + 1));
    let bias = random.vector(2e-3);
    let [inclination, heading, rate] = [0.7 + 0.5 * random.uniform(), 3.0 * random.uniform(), 4.0 + random.uniform()];
    let (gravity, field) = (Vector3::new(0.0, 0.0, 9.806_65), Vector3::new(0.0, 20.0, -44.0));
    let (mut toolface, mut before) = (0.0, None);
    let mut sample = |k: u64| {
        let t = k as f64 * PERIOD_S;
        let stretch = (t - 5.0) % 17.0;
        let is_turning = t > 5.0 && stretch < 12.0;
        let ramp = if is_turning { stretch.min(12.0 - stretch).min(1.0) } else { 0.0 };
        toolface += rate * ramp * PERIOD_S;
        let tilt = inclination + swing_rad * libm::sin(t * core::f64::consts::TAU / 60.0);
        let attitude = Rotation3::from_axis_angle(&Vector3::z_axis(), heading)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), tilt)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), toolface);
        let turned: Rotation3<f64> =
            before.map_or(Rotation3::identity(), |before: Rotation3<f64>| before.inverse() * attitude);
        before = Some(attitude);
        let raw = bias + turned.scaled_axis() / PERIOD_S;
        let noise = if is_turning { 1.0 } else { 0.03 };
        let force = attitude.inverse() * gravity + random.vector(noise);
        let read = attitude.inverse() * field + Vector3::z() * axial_ut + random.vector(0.2);
        let readings = [raw + random.vector(1.2e-3), force, read];
        (k * 10_000, readings.map(|v| Reading::Usable(v.cast::<f32>())))
    };
    (0..(seconds / PERIOD_S) as u64).map(&mut sample).collect()
}
