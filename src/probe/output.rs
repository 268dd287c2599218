//! Output of a sample, and the probe's counters.

use crate::attitude::Attitude;

/// Output of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Compensated body rate relative to the earth, rad/s; the last one if the gyro gave no reading.
    pub rate_rad_s: [f32; 3],
    /// Attitude; `None` before the first gravity reading has aligned the filter.
    pub attitude: Option<Attitude>,
}

/// Counters since the configuration; every loss is counted in one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counters {
    /// Samples taken.
    pub samples: u64,
    /// Samples refused because of their time: it did not increase, or it was more than ten seconds ahead or behind and
    /// no sample before had confirmed the step.
    pub out_of_order: u32,
    /// Steps of time over three nominal periods, steps back, and more than three refused samples in a row.
    pub gaps: u32,
    /// Samples with a clipped sensor.
    pub clipped: u32,
    /// Samples without a gyro reading (the last rate was held).
    pub gyro_missing: u32,
    /// Updates whose result was not ready in time.
    pub overruns: u32,
    /// Window reports dropped because `poll` was not called in time.
    pub reports_lost: u32,
    /// Diagnoses dropped because `take_diagnosis` was not called in time.
    pub diagnoses_lost: u32,
    /// Increments (40 ms of motion) that the estimator dropped because `poll` was not called in time.
    pub increments_lost: u32,
}

impl Counters {
    /// Counters of a probe without a configuration.
    pub(super) const ZERO: Self = Self {
        samples: 0,
        out_of_order: 0,
        gaps: 0,
        clipped: 0,
        gyro_missing: 0,
        overruns: 0,
        reports_lost: 0,
        diagnoses_lost: 0,
        increments_lost: 0,
    };
}

/// Increments a counter, which stops at its largest value.
pub(super) const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
