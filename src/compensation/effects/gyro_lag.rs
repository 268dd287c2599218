//! Effect `gyro_lag`.

use super::super::effect::{Effect, MAX_PARAMETERS, Parameter, Sensor, Snapshot};
use nalgebra::Vector3;

/// Delay of the gyro behind the other sensors: it reads w(t - tau), to first order w - tau w'.
///
/// Digital low-pass filters of MEMS parts delay by 1 to 20 ms. Without a reference only the delay against
/// accelerometer and magnetometer is visible.
pub struct GyroLag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "lag_ms", in_unit: 1e3, usual: 0.01, largest: 0.1, signed: false, only_in_estimator: false }];

impl Effect for GyroLag {
    fn name(&self) -> &'static str {
        "gyro_lag"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Gyro
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, _: usize, snapshot: &Snapshot) -> Vector3<f32> {
        -snapshot.acceleration_rad_s2
    }

    fn gyro_delay_s(&self, [lag_s, ..]: &[f32; MAX_PARAMETERS]) -> f32 {
        *lag_s
    }

    fn is_delay(&self) -> bool {
        true
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["accel_lag and mag_lag of the same size and the other sign"]
    }
}
