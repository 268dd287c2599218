//! Effect `mag_lag`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot, VectorError};
use nalgebra::Vector3;

/// Delay of the magnetometer behind the gyro: it reads m(t - tau), to first order m + tau w x m.
///
/// One conversion takes up to 10 ms and is read up to a period late (AK8963: 7.2 ms).
pub struct MagLag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "lag_ms", in_unit: 1e3, usual: 0.015, largest: 0.1, signed: false, only_in_estimator: false }];

impl Effect for MagLag {
    fn name(&self) -> &'static str {
        "mag_lag"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, _: usize, snapshot: &Snapshot) -> Vector3<f32> {
        snapshot.rate_rad_s.cross(&snapshot.field_ut)
    }

    fn vector_error(&self) -> Option<VectorError> {
        Some(VectorError::MagLag)
    }

    fn is_delay(&self) -> bool {
        true
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["eddy_lag under axial rotation", "gyro_lag"]
    }
}
