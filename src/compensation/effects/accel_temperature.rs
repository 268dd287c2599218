//! Effect `accel_temperature`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use nalgebra::Vector3;

/// Accelerometer offset proportional to temperature: c (T - 25 degC) in excess on each axis. Zero-g level
/// over temperature in data sheets: 0.1 mg/K (LSM6DSO) to 1 mg/K (BMI160).
pub struct AccelTemperature;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 5e-3, largest: 5e-2, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_m_s2_k"), parameter("y_m_s2_k"), parameter("z_m_s2_k")];

impl Effect for AccelTemperature {
    fn name(&self) -> &'static str {
        "accel_temperature"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Accelerometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * snapshot.warming_k
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["an offset that drifts with time"]
    }
}
