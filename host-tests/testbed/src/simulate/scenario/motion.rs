use serde::Deserialize;

/// Direction of the hole and how it changes. Azimuths count from magnetic north.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hole {
    /// Inclination at the start, degrees from the vertical. Default 45.
    pub inclination_deg: f64,
    /// Azimuth at the start, degrees. Default 60.
    pub azimuth_deg: f64,
    /// Change of inclination, degrees per hour of drilling. Default 3 (some 3 deg in 30 m at 30 m/h).
    pub build_rate_deg_h: f64,
    /// Change of azimuth, degrees per hour of drilling. Default 2.
    pub turn_rate_deg_h: f64,
}

impl Default for Hole {
    fn default() -> Self {
        Self { inclination_deg: 45.0, azimuth_deg: 60.0, build_rate_deg_h: 3.0, turn_rate_deg_h: 2.0 }
    }
}

/// Rotation about the tool axis.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rotation {
    /// Toolface at rest, degrees. Default 35.
    pub toolface_deg: f64,
    /// Mean speed, revolutions per minute. Default 30 (180 deg/s).
    pub mean_rpm: f64,
    /// Depth of stick-slip: at 1 the speed swings between 0 and twice the mean. It wanders down to 0.6 of
    /// this. Default 0.95.
    pub stick_slip: f64,
    /// Frequency of stick-slip, Hz; its phase wanders. Default 0.25.
    pub stick_slip_hz: f64,
}

impl Default for Rotation {
    fn default() -> Self {
        Self { toolface_deg: 35.0, mean_rpm: 30.0, stick_slip: 0.95, stick_slip_hz: 0.25 }
    }
}

/// Slow tilts of the tool axis, in two directions across the hole: they excite the lateral gyro axes as a
/// real string does.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wobble {
    /// Root mean square in each direction, degrees. Default 1.
    pub rms_deg: f64,
    /// Band, Hz. Default 0.1 to 0.5.
    pub band_hz: [f64; 2],
}

impl Default for Wobble {
    fn default() -> Self {
        Self { rms_deg: 1.0, band_hz: [0.1, 0.5] }
    }
}
