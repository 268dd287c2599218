//! Effect `gyro_bias_step`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot};
use crate::units::DEGREES;
use nalgebra::Vector3;

/// Permanent step of the gyro's bias by a shock, d on each axis.
///
/// The estimator adds the step from its shock on, for some shocks separately. The flown bias includes the step, so that
/// nothing is taken out of the readings: the term is zero.
pub struct GyroBiasStep;

const fn parameter(name: &'static str) -> Parameter {
    // Usual, 0.1 deg/s: a shock's effect on common sensors. Largest, 5 deg/s: all of the zero-rate output that data
    // sheets allow after soldering.
    Parameter {
        name,
        in_unit: DEGREES,
        usual: 0.1 / DEGREES,
        largest: 5.0 / DEGREES,
        signed: true,
        only_in_estimator: false,
    }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_deg_s"), parameter("y_deg_s"), parameter("z_deg_s")];

impl Effect for GyroBiasStep {
    fn name(&self) -> &'static str {
        "gyro_bias_step"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, _: usize, _: &Snapshot) -> Vector3<f32> {
        Vector3::zeros()
    }

    fn is_bias_step(&self) -> bool {
        true
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["a step of P where the tool turns at one rate"]
    }
}
