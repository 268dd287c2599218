use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis, component};
use nalgebra::Vector3;

const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;
/// Factor from rad/s per m/s^2 to deg/s per g.
const RAD_S2_PER_M_IN_DEG_S_G: f32 = STANDARD_GRAVITY_M_S2 * 180.0 / core::f32::consts::PI;
/// Usual and largest value: 0.1 and 2 deg/s per g.
const USUAL: f32 = 0.1 / RAD_S2_PER_M_IN_DEG_S_G;
const LARGEST: f32 = 2.0 / RAD_S2_PER_M_IN_DEG_S_G;

/// Acceleration sensitivity of the gyro: it reads G a in excess, G row by row. Data sheets state 0.01 to 0.1
/// deg/s per g.
///
/// In a vertical hole it is a bias.
pub struct GSensitivity;

const fn parameter(name: &'static str) -> Parameter {
    Parameter {
        name,
        in_unit: RAD_S2_PER_M_IN_DEG_S_G,
        usual: USUAL,
        largest: LARGEST,
        signed: true,
        only_in_estimator: false,
    }
}

const PARAMETERS: [Parameter; 9] = [
    parameter("gxx_deg_s_g"),
    parameter("gxy_deg_s_g"),
    parameter("gxz_deg_s_g"),
    parameter("gyx_deg_s_g"),
    parameter("gyy_deg_s_g"),
    parameter("gyz_deg_s_g"),
    parameter("gzx_deg_s_g"),
    parameter("gzy_deg_s_g"),
    parameter("gzz_deg_s_g"),
];

impl Effect for GSensitivity {
    fn name(&self) -> &'static str {
        "g_sensitivity"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, moment: &Snapshot) -> Vector3<f32> {
        axis(k / 3) * component(&moment.force_m_s2, k % 3)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["gyro_bias where the attitude hardly changes"]
    }
}
