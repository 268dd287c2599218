//! Earth at the probe: gravity, field, latitude, declination.

use super::{ConfigError, check};
use crate::units::STANDARD_GRAVITY_M_S2;
use core::f32::consts::{FRAC_PI_2, PI};

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

    /// Checks every number.
    ///
    /// # Errors
    /// Names the first field that cannot be used.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let within = |x: Option<f32>, most: f32| x.is_none_or(|x| libm::fabsf(x) <= most);
        check((9.0..=10.5).contains(&self.gravity_m_s2), "earth.gravity_m_s2", "9.0 to 10.5")?;
        // The earth's own is 22 to 67.
        let is_a_field = self.magnetic_field_ut.is_none_or(|field| (15.0..=80.0).contains(&field));
        check(is_a_field, "earth.magnetic_field_ut", "15 to 80 (microtesla; 1 gauss is 100)")?;
        check(within(self.dip_rad, FRAC_PI_2), "earth.dip_rad", "-pi/2 to pi/2")?;
        check(within(self.declination_rad, PI), "earth.declination_rad", "-pi to pi")?;
        check(within(self.latitude_rad, FRAC_PI_2), "earth.latitude_rad", "-pi/2 to pi/2")
    }
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
