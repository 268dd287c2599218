//! Effect `gyro_scale_asymmetry`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, axis, component};
use nalgebra::Vector3;

/// Scale factor that differs between the two directions: the gyro reads k |w| in excess on each axis. The difference
/// shows only with rotation both ways.
pub struct GyroScaleAsymmetry;

const fn parameter(name: &'static str) -> Parameter {
    Parameter { name, in_unit: 1e2, usual: 5e-3, largest: 5e-2, signed: true, only_in_estimator: false }
}

const PARAMETERS: [Parameter; 3] = [parameter("x_percent"), parameter("y_percent"), parameter("z_percent")];

impl Effect for GyroScaleAsymmetry {
    fn name(&self) -> &'static str {
        "gyro_scale_asymmetry"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, k: usize, snapshot: &Snapshot) -> Vector3<f32> {
        axis(k) * libm::fabsf(component(&snapshot.rate_rad_s, k))
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["scale factor where the rotation never reverses"]
    }
}
