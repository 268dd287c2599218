//! Reasons for which a configuration cannot be used.

use crate::status::MwdStatus;
use meerkat_mwd::config::ConfigError;

/// Reason for which a configuration cannot be used.
pub(crate) enum ConfigFault {
    /// Another version's struct.
    Version,
    /// A field out of its bounds.
    Field(ConfigError),
    /// A number that stands for a choice, and for none of the choices.
    Choice { field: &'static str, must_be: &'static str },
}

impl ConfigFault {
    pub(crate) fn status(&self) -> MwdStatus {
        match self {
            Self::Version => MwdStatus::ErrorVersion,
            Self::Field(_) | Self::Choice { .. } => MwdStatus::ErrorConfig,
        }
    }

    pub(crate) fn texts(&self) -> [&'static str; 2] {
        match self {
            Self::Version => ["version", "MWD_CONFIG_VERSION of the library that is linked"],
            Self::Field(error) => [error.field, error.must_be],
            Self::Choice { field, must_be } => [field, must_be],
        }
    }
}
