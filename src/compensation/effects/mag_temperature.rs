//! Effect `mag_temperature`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis};
use nalgebra::Vector3;

/// Magnetometer offset proportional to temperature: c (T - 25 degC) in excess on each axis. Zero-gauss level
/// over temperature in data sheets: 0.03 uT/K (IIS2MDC, LSM303AGR).
pub struct MagTemperature;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 0.03, largest: 0.5, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_ut_k"), parameter("y_ut_k"), parameter("z_ut_k")];

impl Effect for MagTemperature {
    fn name(&self) -> &'static str {
        "mag_temperature"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * snapshot.warming_k
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["a hard iron that drifts with time"]
    }
}
