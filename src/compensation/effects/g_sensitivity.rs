//! Effect `g_sensitivity`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis, component};
use crate::units::DEG_S_PER_G;
use nalgebra::Vector3;

/// Usual and largest value: 0.1 and 2 deg/s per g.
const USUAL: f32 = 0.1 / DEG_S_PER_G;
const LARGEST: f32 = 2.0 / DEG_S_PER_G;

/// Acceleration sensitivity of the gyro: it reads G a in excess, G row by row. Data sheets state 0.01 to 0.1
/// deg/s per g.
///
/// In a vertical hole it cannot be told from a bias.
pub struct GSensitivity;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: DEG_S_PER_G, usual: USUAL, largest: LARGEST, signed: true, only_in_estimator: false }
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

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k / 3) * component(&snapshot.force_m_s2, k % 3)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["gyro_bias where the attitude hardly changes"]
    }
}
