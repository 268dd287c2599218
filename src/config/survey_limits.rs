//! Limits of a survey's quality.

use super::{ConfigError, all_positive};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Limits of |G|, |B| and dip against their references.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SurveyLimits {
    /// True if the limits follow from the error model: `deviations` standard deviations of measured less reference at
    /// that attitude. `false`, the default: the fixed `field_ut`, `dip_rad` and `gravity_m_s2`. Those of a rotating
    /// survey, which vibration and delays make less certain, always follow from the error model.
    pub propagated: bool,
    /// Total field, microtesla. Default 0.3 (300 nT: the ISCWSA's Introduction to wellbore positioning, 22.1
    /// Checking raw data).
    pub field_ut: f32,
    /// Dip, radians. Default 0.25 deg (same source).
    pub dip_rad: f32,
    /// Total gravity, m/s^2. Default 2.5 mg, a common rule without a source here. Standard gravity, the
    /// default reference, is off by up to 2.7 mg at a well: configure the local value.
    pub gravity_m_s2: f32,
    /// Standard deviations within which a survey is good if limits are propagated. Default 2 (95 %).
    pub deviations: f32,
    /// Ratio of a difference to its limit beyond which a survey is bad; between 1 and this ratio it is doubtful.
    /// Default 1.5: with a limit of two deviations, bad begins at three.
    pub bad_over_limit: f32,
}

impl SurveyLimits {
    /// All-zero settings of a static before it is configured.
    pub(super) const UNSET: Self = Self {
        propagated: false,
        field_ut: 0.0,
        dip_rad: 0.0,
        gravity_m_s2: 0.0,
        deviations: 0.0,
        bad_over_limit: 0.0,
    };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [self.field_ut, self.dip_rad, self.gravity_m_s2, self.deviations, self.bad_over_limit],
            &[
                "survey.limits.field_ut",
                "survey.limits.dip_rad",
                "survey.limits.gravity_m_s2",
                "survey.limits.deviations",
                "survey.limits.bad_over_limit",
            ],
        )?;
        if self.bad_over_limit >= 1.0 {
            Ok(())
        } else {
            Err(ConfigError { field: "survey.limits.bad_over_limit", must_be: "at least 1" })
        }
    }
}

impl Default for SurveyLimits {
    fn default() -> Self {
        Self {
            propagated: false,
            field_ut: 0.3,
            dip_rad: 0.25_f32.to_radians(),
            gravity_m_s2: 2.5e-3 * STANDARD_GRAVITY_M_S2,
            deviations: 2.0,
            bad_over_limit: 1.5,
        }
    }
}
