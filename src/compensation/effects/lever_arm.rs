//! Effect `lever_arm`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use nalgebra::Vector3;

/// Distance r of the accelerometer from the centre of rotation: it reads w x (w x r) + w' x r in excess. 2 cm
/// give 0.32 g at 120 rpm.
///
/// Nothing in a collar is farther than 0.1 m from the collar's axis: a longer arm belongs to something that carries the
/// sensor.
pub struct LeverArm;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1e3, usual: 0.03, largest: 0.1, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_mm"), parameter("y_mm"), parameter("z_mm")];

impl Effect for LeverArm {
    fn name(&self) -> &'static str {
        "lever_arm"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Accelerometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        let arm = axis(k);
        let w = &snapshot.rate_rad_s;
        w.cross(&w.cross(&arm)) + snapshot.acceleration_rad_s2.cross(&arm)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["motion about a pivot"]
    }
}
