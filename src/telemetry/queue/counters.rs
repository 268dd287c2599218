//! Counters of the telemetry queue.

use serde::{Deserialize, Serialize};

/// Counters of sent and dropped frames, which stop at their largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LineCounters {
    /// Frames given to the line.
    pub frames: u32,
    /// Attitudes of the stream that were dropped because the line is too slow; decimated ones do not count.
    pub attitude_dropped: u32,
    /// Samples of a recording that were dropped.
    pub samples_dropped: u32,
    /// Attempts to push a result that found no room, repeated ones included.
    pub results_refused: u32,
}

impl LineCounters {
    pub(super) const NONE: Self = Self { frames: 0, attitude_dropped: 0, samples_dropped: 0, results_refused: 0 };
}

/// Adds one to a counter, which stops at its largest value.
pub(super) const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
