//! Effect `gyro_scale_temperature`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis, component};
use nalgebra::Vector3;

/// Scale factor that changes with temperature: the gyro reads k (T - 25 degC) w in excess on each axis.
/// Sensitivity over temperature in data sheets: 0.007 %/K (LSM6DSO) to 0.02 %/K (BMI160).
pub struct GyroScaleTemperature;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1e2, usual: 2e-4, largest: 2e-3, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_percent_k"), parameter("y_percent_k"), parameter("z_percent_k")];

impl Effect for GyroScaleTemperature {
    fn name(&self) -> &'static str {
        "gyro_scale_temperature"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * (component(&snapshot.rate_rad_s, k) * snapshot.warming_k)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["a scale factor that drifts with time"]
    }
}
