//! Effect `accel_bias`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, axis, negated};
use nalgebra::Vector3;

/// Constant offset of the accelerometer: a term once per revolution in the earth frame.
///
/// Zero-g offsets of MEMS parts are 20 to 80 mg before and a few mg after calibration (LSM6DSO: 20 mg).
pub struct AccelBias;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 0.2, largest: 1.0, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_m_s2"), parameter("y_m_s2"), parameter("z_m_s2")];

impl Effect for AccelBias {
    fn name(&self) -> &'static str {
        "accel_bias"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Accelerometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, _: &Snapshot) -> Vector3<f32> {
        axis(k)
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::AccelBias)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], _: f32) -> [f32; MAX_PARAMETERS] {
        negated(unknowns, 1.0)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["a slow horizontal acceleration"]
    }
}
