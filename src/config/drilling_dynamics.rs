//! Settings of the drilling dynamics (vibration, shocks, rotation).

use super::{ConfigError, all_positive};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Settings of the drilling dynamics: vibration, shocks and rotation over a window.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct DynamicsConfig {
    /// Length of a window, seconds. Default 30: three periods of the slowest stick-slip, 0.1 Hz (of 0.1 to 2
    /// Hz).
    pub window_s: f32,
    /// Averaging time of the axial rate before its least and largest values are taken, seconds. Default 0.1: a fifth of
    /// the fastest stick-slip's period, longer than the periods of lateral vibration.
    pub rate_averaging_s: f32,
    /// Vibration that counts as a shock, m/s^2. Default 10 g: a choice, within the range of a 16 g accelerometer with
    /// gravity added.
    pub shock_m_s2: f32,
    /// Time for which vibration must stay below half of `shock_m_s2` to end a shock, seconds. Default 0.02: a
    /// choice, so that the ringing of one blow, above 50 Hz, is not counted again.
    pub shock_pause_s: f32,
}

impl DynamicsConfig {
    /// All-zero settings of a static before it is configured.
    pub(super) const UNSET: Self = Self { window_s: 0.0, rate_averaging_s: 0.0, shock_m_s2: 0.0, shock_pause_s: 0.0 };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [self.window_s, self.rate_averaging_s, self.shock_m_s2, self.shock_pause_s],
            &[
                "survey.dynamics.window_s",
                "survey.dynamics.rate_averaging_s",
                "survey.dynamics.shock_m_s2",
                "survey.dynamics.shock_pause_s",
            ],
        )?;
        if self.window_s >= 2.0 * self.rate_averaging_s {
            Ok(())
        } else {
            Err(ConfigError { field: "survey.dynamics.window_s", must_be: "at least twice rate_averaging_s" })
        }
    }
}

impl Default for DynamicsConfig {
    fn default() -> Self {
        Self { window_s: 30.0, rate_averaging_s: 0.1, shock_m_s2: 10.0 * STANDARD_GRAVITY_M_S2, shock_pause_s: 0.02 }
    }
}
