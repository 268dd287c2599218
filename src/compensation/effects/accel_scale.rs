//! Effect `accel_scale`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, axis, component};
use crate::units::DEGREES;
use nalgebra::Vector3;

/// Scale factors and cross-axis sensitivity of the accelerometer, and a turn of its axes against the gyro's:
/// it reads M f in excess.
///
/// Parameters: the six of M's symmetric part (xx, yy, zz, xy, xz, yz), and the rotation vector of the axes.
pub struct AccelScale;

const fn scale(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 100.0, usual: 5e-3, largest: 0.1, signed: true, only_in_estimator: true }
}

const fn turn(name: &'static str) -> Parameter {
    Parameter { name, in_unit: DEGREES, usual: 5e-3, largest: 0.1, signed: true, only_in_estimator: true }
}

const PARAMETERS: [Parameter; 9] = [
    scale("x_percent"),
    scale("y_percent"),
    scale("z_percent"),
    scale("xy_percent"),
    scale("xz_percent"),
    scale("yz_percent"),
    turn("turn_x_deg"),
    turn("turn_y_deg"),
    turn("turn_z_deg"),
];

impl Effect for AccelScale {
    fn name(&self) -> &'static str {
        "accel_scale"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Accelerometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        let f = &snapshot.force_m_s2;
        match k {
            0..3 => axis(k) * component(f, k),
            3 => Vector3::new(f.y, f.x, 0.0),
            4 => Vector3::new(f.z, 0.0, f.x),
            5 => Vector3::new(0.0, f.z, f.y),
            6 => Vector3::new(0.0, -f.z, f.y),
            7 => Vector3::new(f.z, 0.0, -f.x),
            _ => Vector3::new(-f.y, f.x, 0.0),
        }
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::AccelMatrix)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _: f32) -> [f32; MAX_PARAMETERS] {
        let [xx, yy, zz, xy, xz, yz, of_z, of_y, of_x] = *unknowns;
        let root = core::f32::consts::FRAC_1_SQRT_2;
        [-xx, -yy, -zz, -xy * root, -xz * root, -yz * root, of_x * root, -of_y * root, of_z * root]
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["accel_bias at one attitude"]
    }
}
