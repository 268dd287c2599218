use super::{ConfigError, all_positive};

/// When a diagnosis looks for effects beyond the gyro's twelve parameters, and at how much.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct DiagnosisConfig {
    /// Latest samples that a diagnosis looks at, seconds; one begins where the one before ended. Default 36: fewer than the 46 that are
    /// kept, so that there is time to go through them again and again before they are overwritten.
    pub window_s: f32,
    /// What a diagnosis finds takes effect this long after it began, seconds. Default 10, what the chip needs at the usual share of its
    /// time; on a desk there is no need to wait.
    pub latency_s: f32,
}

impl DiagnosisConfig {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self { window_s: 0.0, latency_s: 0.0 };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive([self.window_s, self.latency_s], &["diagnosis.window_s", "diagnosis.latency_s"])?;
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ConfigError { field, must_be }) };
        check(self.window_s >= 24.0, "diagnosis.window_s", "at least 24, for its groups of test windows")?;
        check(self.latency_s <= self.window_s, "diagnosis.latency_s", "at most window_s")?;
        check(self.window_s + self.latency_s <= 46.0, "diagnosis.window_s", "at most 46 less latency_s, what is kept")
    }
}

impl Default for DiagnosisConfig {
    fn default() -> Self {
        Self { window_s: 36.0, latency_s: 10.0 }
    }
}
