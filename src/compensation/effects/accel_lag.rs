//! Effect `accel_lag`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, VectorError};
use nalgebra::Vector3;

/// Delay of the accelerometer behind the gyro: it reads a(t - tau). Gravity turns in the body by -w x a, so
/// that the reading is a + tau w x a to first order.
pub struct AccelLag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "lag_ms", in_unit: 1e3, usual: 0.01, largest: 0.1, signed: false, only_in_estimator: false }];

impl Effect for AccelLag {
    fn name(&self) -> &'static str {
        "accel_lag"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Accelerometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, _: usize, snapshot: &Snapshot) -> Vector3<f32> {
        snapshot.rate_rad_s.cross(&snapshot.force_m_s2)
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::AccelLag)
    }

    fn is_delay(&self) -> bool {
        true
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["gyro_lag"]
    }
}
