use super::super::effect::{Effect, Moment, Parameter, Sensor, axis};
use nalgebra::Vector3;

/// A constant offset of the field, fixed to the body: once per revolution in its norm.
pub struct HardIron;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 20.0, largest: 200.0, signed: true, turns_axes: false }
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

    fn term(&self, k: usize, _: &Moment) -> Vector3<f32> {
        axis(k)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["axial_interference where the offset lies along the tool axis"]
    }
}
