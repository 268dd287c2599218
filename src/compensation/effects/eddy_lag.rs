//! Effect `eddy_lag`.

use super::super::effect::{Effect, Parameter, Sensor, Snapshot};
use nalgebra::Vector3;

/// Eddy currents in a conductive collar that turns: the field across the axis lags by tau w_z, the field
/// along it does not.
///
/// Usual size: 0.1 to 0.6 deg at 30 rpm, so 0.6 to 3.3 ms.
pub struct EddyLag;

const PARAMETERS: [Parameter; 1] =
    [Parameter { name: "lag_ms", in_unit: 1e3, usual: 0.002, largest: 0.02, signed: false, only_in_estimator: false }];

impl Effect for EddyLag {
    fn name(&self) -> &'static str {
        "eddy_lag"
    }

    fn sensor(&self) -> Sensor {
        Sensor::Magnetometer
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn term(&self, _: usize, snapshot: &Snapshot) -> Vector3<f32> {
        let Snapshot { rate_rad_s: w, field_ut: m, .. } = snapshot;
        Vector3::new(-w.z * m.y, w.z * m.x, 0.0)
    }

    fn aliases(&self) -> &'static [&'static str] {
        &["mag_lag under axial rotation"]
    }
}
