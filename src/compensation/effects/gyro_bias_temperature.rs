//! Effect `gyro_bias_temperature`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use crate::units::DEGREES;
use nalgebra::Vector3;

/// Gyro bias proportional to temperature: c (T - 25 degC) on each axis. Data sheets state 0.005 to 0.05 deg/s
/// per kelvin.
pub struct GyroBiasTemperature;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: DEGREES, usual: 8.7e-4, largest: 1.75e-2, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_deg_s_k"), parameter("y_deg_s_k"), parameter("z_deg_s_k")];

impl Effect for GyroBiasTemperature {
    fn name(&self) -> &'static str {
        "gyro_bias_temperature"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * snapshot.warming_k
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["a bias that drifts with time"]
    }
}
