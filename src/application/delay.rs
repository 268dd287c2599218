//! Delay from a sample's acquisition to its attitude.

/// An attitude later than this is counted, microseconds.
pub const LATE_US: u32 = 2_000;

/// Delays from acquisition to attitude.
#[derive(Clone, Copy, Debug, Default)]
pub struct Delays {
    /// Longest delay, microseconds.
    pub worst_us: u32,
    /// Number of delays over [`LATE_US`].
    pub late: u32,
}

impl Delays {
    /// Counts an attitude of a sample that was read at a time, low halves of microseconds. Of a clock that went back
    /// meanwhile there is no delay.
    pub(super) fn add(&mut self, read_us: u32, now_us: u32) {
        let delay_us = now_us.wrapping_sub(read_us).cast_signed().max(0).cast_unsigned();
        if delay_us > self.worst_us {
            self.worst_us = delay_us;
        }
        if delay_us > LATE_US {
            self.late = self.late.saturating_add(1);
        }
    }
}
