//! Delay from a sample's acquisition to its attitude.

/// An attitude later than this is counted, microseconds.
pub const LATE_US: u64 = 2_000;

/// Delays from acquisition to attitude.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delays {
    /// Longest delay, microseconds.
    pub worst_us: u32,
    /// Number of delays over [`LATE_US`].
    pub late: u32,
}

impl Delays {
    pub(super) fn add(&mut self, delay_us: u64) {
        let delay = u32::try_from(delay_us).unwrap_or(u32::MAX);
        if delay > self.worst_us {
            self.worst_us = delay;
        }
        if delay_us > LATE_US {
            self.late = self.late.saturating_add(1);
        }
    }
}
