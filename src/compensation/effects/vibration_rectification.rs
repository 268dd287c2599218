use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use nalgebra::Vector3;

const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;
/// Factor from rad/s per m/s^2 to deg/s per g.
const RAD_S2_PER_M_IN_DEG_S_G: f32 = STANDARD_GRAVITY_M_S2 * 180.0 / core::f32::consts::PI;
/// Usual and largest value: 0.5 and 2 deg/s per g^2.
const USUAL: f32 = 0.5 / (RAD_S2_PER_M_IN_DEG_S_G * STANDARD_GRAVITY_M_S2);
const LARGEST: f32 = 2.0 / (RAD_S2_PER_M_IN_DEG_S_G * STANDARD_GRAVITY_M_S2);

/// Vibration rectification: a bias k |a|^2 on each axis, |a|^2 the mean square of the specific force.
///
/// Usual size: 0.01 to 0.1 deg/s per g^2. Under constant vibration it is a bias, and so is gravity's own part
/// of it.
pub struct VibrationRectification;

const fn parameter(name: &'static str) -> Parameter {
    Parameter {
        name,
        in_unit: RAD_S2_PER_M_IN_DEG_S_G * STANDARD_GRAVITY_M_S2,
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

    fn term(&self, k: usize, moment: &Snapshot) -> Vector3<f32> {
        axis(k) * moment.square_force_m2_s4
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["gyro_bias and coning at constant vibration"]
    }
}
