//! A simulated probe that is turned from rest to rest, with the nine errors of each vector sensor.

use meerkat_mwd::{Sample, SampleFlags};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, UnitVector3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use testbed::trace::{Keys, Trace};

pub const GRAVITY_M_S2: f64 = 9.81;
pub const FIELD_UT: f64 = 50.0;
const DIP_RAD: f64 = 1.1;
const RATE_HZ: usize = 100;
/// Noise of one reading: 5 mg, and what LIS3MDL-like magnetometers have.
const ACCEL_NOISE_M_S2: f64 = 0.05;
const MAG_NOISE_UT: f64 = 0.3;
const GYRO_NOISE_RAD_S: f64 = 0.001;

pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Box and Muller.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    pub fn normal3(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }

    /// Never nearer to zero than half of `sigma`.
    fn off_centre(&mut self, sigma: f64) -> f64 {
        let draw = self.normal();
        if draw.abs() < 0.5 { self.off_centre(sigma) } else { sigma * draw }
    }

    pub fn attitude(&mut self) -> UnitQuaternion<f64> {
        let axis = UnitVector3::new_normalize(self.normal3());
        let about = UnitQuaternion::from_axis_angle(&axis, std::f64::consts::PI * self.uniform());
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::TAU * self.uniform()) * about
    }

    /// Nine errors in the order of `mwd::calibrate::NAMES`.
    pub fn errors(&mut self, scale: f64, cross: f64, offset: f64) -> [f64; 9] {
        let sigmas = [scale, scale, scale, cross, cross, cross, offset, offset, offset];
        sigmas.map(|sigma| self.off_centre(sigma))
    }
}

/// Reading of a sensor with errors `x` for `truth`.
fn reads(x: &[f64; 9], truth: Vector3<f64>) -> Vector3<f64> {
    let s = Matrix3::new(x[0], x[3], x[4], x[3], x[1], x[5], x[4], x[5], x[2]);
    (Matrix3::identity() + s).try_inverse().unwrap() * truth + Vector3::new(x[6], x[7], x[8])
}

pub struct Probe {
    pub accel_errors: [f64; 9],
    pub mag_errors: [f64; 9],
    /// From the magnetometer's axes to the accelerometer's, rad.
    pub mag_turn_rad: Vector3<f64>,
    pub has_mag: bool,
    /// Field of the place, microtesla.
    pub field_ut: f64,
}

impl Probe {
    pub fn drawn(random: &mut Random) -> Self {
        Self {
            accel_errors: random.errors(0.02, 0.01, 0.3),
            mag_errors: random.errors(0.05, 0.03, 10.0),
            mag_turn_rad: Vector3::zeros(),
            has_mag: true,
            field_ut: FIELD_UT,
        }
    }

    /// Rests of three seconds in these attitudes (body to NED), a second and a half of turning between.
    pub fn turned(&self, attitudes: &[UnitQuaternion<f64>], random: &mut Random) -> Trace {
        let mut path = Vec::new();
        for pair in attitudes.windows(2) {
            path.extend(std::iter::repeat_n(pair[0], 3 * RATE_HZ));
            let steps = 3 * RATE_HZ / 2;
            path.extend((0..steps).map(|k| pair[0].slerp(&pair[1], k as f64 / steps as f64)));
        }
        path.extend(std::iter::repeat_n(*attitudes.last().unwrap(), 3 * RATE_HZ));
        let bias_rad_s = Vector3::new(0.01, -0.02, 0.015);
        let field_ut = Vector3::new(DIP_RAD.cos(), 0.0, DIP_RAD.sin()) * self.field_ut;
        let turn = Rotation3::new(self.mag_turn_rad);
        let sample = |k: usize| {
            let q = path[k];
            let next = path.get(k + 1).unwrap_or(&q);
            let rate = (q.inverse() * next).scaled_axis() * RATE_HZ as f64;
            let force = q.inverse() * Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
            let field = turn.inverse() * (q.inverse() * field_ut);
            let noisy =
                |v: Vector3<f64>, noise: f64, random: &mut Random| (v + random.normal3() * noise).map(|x| x as f32);
            let mut flags = SampleFlags::TEMPERATURE_MISSING;
            flags.set(SampleFlags::MAG_MISSING, !self.has_mag);
            let mag = noisy(reads(&self.mag_errors, field), MAG_NOISE_UT, random);
            Sample {
                t_us: 10_000 * k as u64,
                gyro_rad_s: noisy(rate + bias_rad_s, GYRO_NOISE_RAD_S, random).into(),
                accel_m_s2: noisy(reads(&self.accel_errors, force), ACCEL_NOISE_M_S2, random).into(),
                mag_ut: if self.has_mag { mag.into() } else { [0.0; 3] },
                flags,
                ..Sample::default()
            }
        };
        let samples = (0..path.len()).map(sample).collect();
        let keys = Keys {
            gravity_m_s2: Some(GRAVITY_M_S2),
            magnetic_field_ut: Some(self.field_ut),
            accel_full_scale_m_s2: Some(19.6),
            mag_full_scale_ut: Some(400.0),
            ..Keys::default()
        };
        Trace { samples, keys, ..Trace::default() }
    }
}

/// Attitudes all around.
pub fn all_around(count: usize, random: &mut Random) -> Vec<UnitQuaternion<f64>> {
    (0..count).map(|_| random.attitude()).collect()
}
