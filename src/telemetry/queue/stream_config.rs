//! Settings of the stream over the line.

use crate::config::{ConfigError, check};
use serde::{Deserialize, Serialize};

/// Format of an attitude in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum AttitudeFormat {
    /// Quantised angles, some 30 bytes on the line.
    #[default]
    Compact,
    /// All bits of the [`Output`](crate::probe::Output), some 80 bytes.
    Exact,
}

/// Settings of the stream: bandwidth, rate and format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[serde(default, deny_unknown_fields)]
pub struct StreamConfig {
    /// Bandwidth, bytes per second; 100 to 10,000,000. Default 10,368: nine tenths of 115,200 baud with 10 bits a byte.
    pub bytes_per_s: u32,
    /// Decimation: one output in this many is sent; 0 sends none; at most 10,000. Default 20: 10 a second at 200 Hz.
    pub attitude_every: u16,
    /// Format of an attitude.
    pub attitude_format: AttitudeFormat,
    /// Age at which a waiting attitude is dropped, microseconds; 1,000 to 60,000,000. Default 500,000.
    pub max_age_us: u32,
}

impl StreamConfig {
    /// All-zero settings of a static before it is configured.
    pub(super) const UNSET: Self =
        Self { bytes_per_s: 0, attitude_every: 0, attitude_format: AttitudeFormat::Compact, max_age_us: 0 };

    /// Checks every field.
    ///
    /// # Errors
    /// Names the first field that cannot be used.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check((100..=10_000_000).contains(&self.bytes_per_s), "stream.bytes_per_s", "100 to 10000000")?;
        check(self.attitude_every <= 10_000, "stream.attitude_every", "0 to 10000")?;
        check((1_000..=60_000_000).contains(&self.max_age_us), "stream.max_age_us", "1000 to 60000000")
    }
}

impl Default for StreamConfig {
    fn default() -> Self {
        Self { bytes_per_s: 10_368, attitude_every: 20, attitude_format: AttitudeFormat::Compact, max_age_us: 500_000 }
    }
}
