//! Effect `vibration_rectification`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use crate::units::{DEG_S_PER_G, STANDARD_GRAVITY_M_S2};
use nalgebra::Vector3;

/// Usual and largest value: 0.5 and 2 deg/s per g^2.
const USUAL: f32 = 0.5 / (DEG_S_PER_G * STANDARD_GRAVITY_M_S2);
const LARGEST: f32 = 2.0 / (DEG_S_PER_G * STANDARD_GRAVITY_M_S2);

/// Vibration rectification: a bias k |a|^2 on each axis, |a|^2 the mean square of the specific force.
///
/// Usual size: 0.01 to 0.1 deg/s per g^2. Under constant vibration it cannot be told from a bias, nor can gravity's own
/// part of it.
pub struct VibrationRectification;

const fn parameter(name: &'static str) -> Parameter {
    Parameter {
        name,
        in_unit: DEG_S_PER_G * STANDARD_GRAVITY_M_S2,
        usual: USUAL,
        largest: LARGEST,
        signed: true,
        only_in_estimator: false,
    }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_deg_s_g2"), parameter("y_deg_s_g2"), parameter("z_deg_s_g2")];

impl Effect for VibrationRectification {
    fn name(&self) -> &'static str {
        "vibration_rectification"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * snapshot.square_force_m2_s4
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["gyro_bias and coning at constant vibration"]
    }
}
