//! Effect `soft_iron`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, negated};
use crate::units::DEGREES;
use nalgebra::Vector3;

/// Soft iron, and a turn of the magnetometer's axes against the gyro's: the field reads M m in excess, M
/// without a trace (a trace only changes the field's unit, and the evidence would favour it falsely). A term twice per
/// revolution in the norm.
///
/// Parameters: the five of M's symmetric part, (xx - yy) / 2, (xx + yy - 2 zz) / 2 sqrt 3, xy, xz, yz, and
/// the rotation vector of the axes.
pub struct SoftIron;

const fn iron(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 100.0, usual: 0.03, largest: 0.2, signed: true, only_in_estimator: false }
}

const fn turn(name: &'static str) -> Parameter {
    Parameter { name, in_unit: DEGREES, usual: 0.03, largest: 0.2, signed: true, only_in_estimator: true }
}

const PARAMETERS: [Parameter; 8] = [
    iron("across_percent"),
    iron("along_percent"),
    iron("xy_percent"),
    iron("xz_percent"),
    iron("yz_percent"),
    turn("turn_x_deg"),
    turn("turn_y_deg"),
    turn("turn_z_deg"),
];

/// 1 / sqrt 3.
const ROOT: f32 = 0.577_350_26;

impl Effect for SoftIron {
    fn name(&self) -> &'static str {
        "soft_iron"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        let m = &snapshot.field_ut;
        match k {
            0 => Vector3::new(m.x, -m.y, 0.0),
            1 => Vector3::new(m.x, m.y, -2.0 * m.z) * ROOT,
            2 => Vector3::new(m.y, m.x, 0.0),
            3 => Vector3::new(m.z, 0.0, m.x),
            4 => Vector3::new(0.0, m.z, m.y),
            5 => Vector3::new(0.0, -m.z, m.y),
            6 => Vector3::new(m.z, 0.0, -m.x),
            _ => Vector3::new(-m.y, m.x, 0.0),
        }
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::MagMatrix)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _: f32) -> [f32; MAX_PARAMETERS] {
        let [across, along, xy, xz, yz, turned_xy, turned_xz, turned_yz, _] = *unknowns;
        let root = core::f32::consts::FRAC_1_SQRT_2;
        // A turn about z reads (-y, x): its unknown is that of yx, the negated one of xy.
        negated(&[across, along, xy, xz, yz, -turned_yz, turned_xz, -turned_xy, 0.0], root)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["mag_misalignment", "P, for its antisymmetric part"]
    }
}
