//! A probe whose true motion is known, and what its sensors read, in double precision.

use crate::rig::rotation::{angles_and_sigmas, rotation};
use meerkat_mwd::attitude::{Attitude, AttitudeFilter, AttitudeFlags};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

pub const GRAVITY_M_S2: f64 = 9.806_65;

/// Normal deviates by the sum of twelve uniform ones.
pub struct Noise(Xoshiro128PlusPlus);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    pub fn uniform(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| f64::from(self.0.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
    }

    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal())
    }
}

/// An exponentially correlated vector (Ornstein-Uhlenbeck).
pub struct Correlated {
    pub value: Vector3<f64>,
    sigma: f64,
    time_s: f64,
}

impl Correlated {
    pub fn new(noise: &mut Noise, sigma: f64, time_s: f64) -> Self {
        Self { value: noise.vector() * sigma, sigma, time_s }
    }

    pub fn step(&mut self, noise: &mut Noise, dt_s: f64) {
        let keep = (-dt_s / self.time_s).exp();
        self.value = self.value * keep + noise.vector() * (self.sigma * (1.0 - keep * keep).sqrt());
    }
}

/// The true attitude.
pub struct Truth {
    pub q: UnitQuaternion<f64>,
}

impl Truth {
    /// From azimuth, inclination and toolface, degrees.
    pub fn at(azimuth_deg: f64, inclination_deg: f64, toolface_deg: f64) -> Self {
        let turn = |axis, deg: f64| UnitQuaternion::from_axis_angle(&axis, deg.to_radians());
        let q = turn(Vector3::z_axis(), azimuth_deg)
            * turn(Vector3::y_axis(), inclination_deg)
            * turn(Vector3::z_axis(), toolface_deg);
        Self { q }
    }

    /// Turns by a body rate over a step.
    pub fn turn(&mut self, rate_rad_s: &Vector3<f64>, dt_s: f64) {
        self.q *= UnitQuaternion::from_scaled_axis(rate_rad_s * dt_s);
    }

    /// Reading of an ideal accelerometer under an acceleration (NED).
    pub fn force(&self, acceleration_ned: &Vector3<f64>) -> Vector3<f64> {
        self.q.inverse() * (acceleration_ned - Vector3::new(0.0, 0.0, GRAVITY_M_S2))
    }

    /// Reading of an ideal magnetometer in a field of 50 uT at this dip, turned by a heading error.
    pub fn field(&self, dip_deg: f64, heading_error_rad: f64) -> Vector3<f64> {
        let (sine, cosine) = dip_deg.to_radians().sin_cos();
        let north = Vector3::new(cosine * heading_error_rad.cos(), cosine * heading_error_rad.sin(), sine);
        self.q.inverse() * north * 50.0
    }

    fn matrix(&self) -> Matrix3<f64> {
        self.q.to_rotation_matrix().into_inner()
    }

    pub fn inclination_rad(&self) -> f64 {
        let c = self.matrix();
        c.m13.hypot(c.m23).atan2(c.m33)
    }

    pub fn azimuth_rad(&self) -> f64 {
        let c = self.matrix();
        c.m23.atan2(c.m13)
    }

    pub fn magnetic_toolface_rad(&self) -> f64 {
        let c = self.matrix();
        (c.m21 - c.m12).atan2(c.m11 + c.m22)
    }

    /// Angle between the true vertical and the estimated one.
    pub fn tilt_error_rad(&self, attitude: &Attitude) -> f64 {
        let estimate = rotation(attitude.q.map(f64::from));
        (estimate.inverse() * Vector3::z()).angle(&(self.q.inverse() * Vector3::z()))
    }
}

/// The difference of two angles, -pi to pi.
pub fn apart(a_rad: f64, b_rad: f64) -> f64 {
    (a_rad - b_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
}

/// Feeds one sample to the filter and returns its attitude.
pub fn feed(
    filter: &mut AttitudeFilter,
    dt_s: f64,
    rate: &Vector3<f64>,
    force: Option<Vector3<f64>>,
    field: Option<Vector3<f64>>,
) -> Option<Attitude> {
    filter.propagate(dt_s as f32, &rate.cast());
    let (force, field) = (force.map(|v| v.cast::<f32>()), field.map(|v| v.cast::<f32>()));
    filter.observe(force.as_ref(), field.as_ref());
    filter.attitude(AttitudeFlags::empty())
}

/// Returns true if every number of an attitude is finite and its quaternion a rotation.
pub fn sound(a: &Attitude) -> bool {
    let norm: f32 = a.q.iter().map(|x| x * x).sum();
    angles_and_sigmas(a).iter().all(|x| x.is_finite() && *x >= 0.0) && (norm - 1.0).abs() < 1e-5
}
