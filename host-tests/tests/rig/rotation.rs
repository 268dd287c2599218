//! Rotations and angles of attitudes.

use meerkat_mwd::attitude::Attitude;
use nalgebra::{Quaternion, UnitQuaternion};

pub fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// Angles and their sigmas, radians.
pub fn angles_and_sigmas(a: &Attitude) -> [f32; 7] {
    [
        a.inclination_rad,
        a.azimuth_rad,
        a.gravity_toolface_rad,
        a.magnetic_toolface_rad,
        a.sigma_inclination_rad,
        a.sigma_azimuth_rad,
        a.sigma_toolface_rad,
    ]
}
