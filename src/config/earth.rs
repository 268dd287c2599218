//! Earth at the probe: gravity, field, latitude, declination.

use crate::units::STANDARD_GRAVITY_M_S2;

/// Earth at the probe. `None` means unknown, and nothing is assumed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Earth {
    /// Local gravity, m/s^2. Default 9.80665 (standard gravity, ISO 80000-3).
    pub gravity_m_s2: f32,
    /// Total magnetic field, microtesla.
    pub magnetic_field_ut: Option<f32>,
    /// Magnetic dip below the horizontal, radians.
    pub dip_rad: Option<f32>,
    /// Magnetic declination, radians east of true north. If given, azimuths are true; otherwise magnetic.
    pub declination_rad: Option<f32>,
    /// Geodetic latitude, radians north. If given, the earth's rotation (15.04 deg/h) is removed from the
    /// gyro.
    pub latitude_rad: Option<f32>,
}

impl Earth {
    /// All-zero settings of a static before it is configured.
    pub(crate) const UNSET: Self =
        Self { gravity_m_s2: 0.0, magnetic_field_ut: None, dip_rad: None, declination_rad: None, latitude_rad: None };
}

impl Default for Earth {
    fn default() -> Self {
        Self {
            gravity_m_s2: STANDARD_GRAVITY_M_S2,
            magnetic_field_ut: None,
            dip_rad: None,
            declination_rad: None,
            latitude_rad: None,
        }
    }
}
