use crate::compensation::{Effect, Moment, Parameter, Sensor, effects::SoftIron};
use nalgebra::Vector3;

/// Axes of the magnetometer that have turned: tried beside a library that has no such effect. P takes them where nothing else does, and
/// gravity then shows a bent P like an error of the accelerometer.
pub(super) struct TurnedAxes;

/// Where soft iron has them.
const FIRST: usize = 5;

impl Effect for TurnedAxes {
    fn name(&self) -> &'static str {
        "turned_axes"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        SoftIron.parameters().get(FIRST..).unwrap_or_default()
    }

    fn term(&self, k: usize, moment: &Moment) -> Vector3<f32> {
        SoftIron.term(FIRST + k, moment)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &[]
    }
}
