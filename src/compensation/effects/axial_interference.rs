use super::super::effect::{Effect, Moment, Parameter, Sensor, axis};
use nalgebra::Vector3;

/// A constant offset of the field along the tool axis (z), from magnetised drill string.
///
/// A hard iron that is seen to lie along the axis: one parameter instead of three.
pub struct AxialInterference;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "z_ut", in_unit: 1.0, usual: 20.0, largest: 200.0, signed: true, turns_axes: false }];

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

    fn term(&self, k: usize, _: &Moment) -> Vector3<f32> {
        axis(k + 2)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["hard_iron", "soft iron zz or a wrong reference field at one attitude"]
    }
}
