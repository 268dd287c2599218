use serde::Deserialize;

/// The earth at the probe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EarthSettings {
    /// Gravity, m/s^2. Default 9.80665.
    pub gravity_m_s2: f64,
    /// Total magnetic field, microtesla. Default 50.
    pub magnetic_field_ut: f64,
    /// Magnetic dip, degrees below the horizontal. Default 65.
    pub dip_deg: f64,
    /// Geodetic latitude, degrees north; with it the gyro senses the earth's rotation. Default: none.
    pub latitude_deg: Option<f64>,
    /// Magnetic declination, degrees east of true north; written to the trace. Default: none.
    pub magnetic_declination_deg: Option<f64>,
}

impl Default for EarthSettings {
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.806_65,
            magnetic_field_ut: 50.0,
            dip_deg: 65.0,
            latitude_deg: None,
            magnetic_declination_deg: None,
        }
    }
}
