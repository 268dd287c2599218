//! Effect `gyro_scale_nonlinearity`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis, component};
use nalgebra::Vector3;

/// Scale factor that changes with the rate: the gyro reads k w^3 in excess on each axis.
///
/// Data sheets state 0.1 to 0.5 % of full scale: at most 1e-3 s^2/rad^2 with 125 deg/s, 7e-5 with 500. The effect
/// shows only with changing rates, as in stick-slip.
pub struct GyroScaleNonlinearity;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1.0, usual: 1e-3, largest: 1e-2, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_s2_rad2"), parameter("y_s2_rad2"), parameter("z_s2_rad2")];

impl Effect for GyroScaleNonlinearity {
    fn name(&self) -> &'static str {
        "gyro_scale_nonlinearity"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        let rate = component(&snapshot.rate_rad_s, k);
        axis(k) * (rate * rate * rate)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["scale factor at one rate"]
    }
}
