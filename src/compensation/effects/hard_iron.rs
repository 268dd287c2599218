//! Effect `hard_iron`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, axis, negated};
use nalgebra::Vector3;

/// Constant body-fixed offset of the field (hard iron): a term once per revolution in the field's norm.
pub struct HardIron;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 20.0, largest: 200.0, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_ut"), parameter("y_ut"), parameter("z_ut")];

impl Effect for HardIron {
    fn name(&self) -> &'static str {
        "hard_iron"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, _: &Snapshot) -> Vector3<f32> {
        axis(k)
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::HardIron)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], field_ut: f32) -> [f32; MAX_PARAMETERS] {
        negated(unknowns, field_ut)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["axial_interference where the offset lies along the tool axis"]
    }
}
