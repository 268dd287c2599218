//! Effect `mag_misalignment`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, negated};
use crate::units::DEGREES;
use nalgebra::Vector3;

/// A turn of the magnetometer's axes against the gyro's and the accelerometer's: the field reads r x m in excess.
///
/// The rotation of effect `soft_iron` alone, with three parameters instead of eight. In a vertical hole the
/// accelerometer's bias looks the same, for both turn one of two vectors against the tool axis. Parameters: the
/// rotation vector r.
pub struct MagMisalignment;

const fn turn(name: &'static str) -> Parameter {
    Parameter { name, in_unit: DEGREES, usual: 0.03, largest: 0.2, signed: true, only_in_estimator: true }
}

const PARAMETERS: [Parameter; 3] = [turn("turn_x_deg"), turn("turn_y_deg"), turn("turn_z_deg")];

impl Effect for MagMisalignment {
    fn name(&self) -> &'static str {
        "mag_misalignment"
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
            0 => Vector3::new(0.0, -m.z, m.y),
            1 => Vector3::new(m.z, 0.0, -m.x),
            _ => Vector3::new(-m.y, m.x, 0.0),
        }
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::MagTurn)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _: f32) -> [f32; MAX_PARAMETERS] {
        let [xy, xz, yz, ..] = *unknowns;
        let mut turn = [0.0; MAX_PARAMETERS];
        if let Some(turn) = turn.first_chunk_mut() {
            *turn = [-yz, xz, -xy];
        }
        negated(&turn, core::f32::consts::FRAC_1_SQRT_2)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["soft_iron", "accel_bias in a vertical hole", "P"]
    }
}
