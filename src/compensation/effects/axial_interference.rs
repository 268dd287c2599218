//! Effect `axial_interference`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot, VectorError, axis, negated};
use nalgebra::Vector3;

/// Constant offset of the field along the tool axis (z), from magnetised drill string.
///
/// A hard iron along the axis, with one parameter instead of three.
pub struct AxialInterference;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "z_ut", in_unit: 1.0, usual: 20.0, largest: 200.0, signed: true, only_in_estimator: false }];

impl Effect for AxialInterference {
    fn name(&self) -> &'static str {
        "axial_interference"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, _: &Snapshot) -> Vector3<f32> {
        axis(k + 2)
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::AxialIron)
    }

    fn parameters_of(&self, unknowns: &[f32; MAX_PARAMETERS], field_ut: f32) -> [f32; MAX_PARAMETERS] {
        negated(unknowns, field_ut)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["hard_iron", "soft iron zz or a wrong reference field at one attitude"]
    }
}
