use crate::attitude::Attitude;

/// What one sample gives.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Compensated body rate relative to the earth, rad/s; the last one, where the gyro gave no reading.
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
    /// Samples refused because of their time: it did not increase, or was more than ten seconds ahead and no
    /// other had said so.
    pub out_of_order: u32,
    /// Steps in time over 3 nominal periods.
    pub gaps: u32,
    /// Samples with a clipped sensor.
    pub clipped: u32,
    /// Samples without a gyro reading (the last rate was held).
    pub gyro_missing: u32,
    /// Updates of what flies whose result was not ready in time.
    pub overruns: u32,
    /// Window reports dropped because nobody polled them.
    pub reports_lost: u32,
    /// Diagnoses' reports dropped because nobody took them.
    pub diagnoses_lost: u32,
    /// Increments that the estimator lost because nobody polled.
    pub increments_lost: u32,
}

/// Counts one more; a full counter stays.
pub(super) const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
