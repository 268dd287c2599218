//! Line of known bandwidth: the time from which it is free.

/// Longest time that a line may lag behind its bandwidth, microseconds: a firmware that serves the line once a sample
/// can be this late.
const CATCH_UP_US: u64 = 10_000;

/// Time from which a line of known bandwidth is free.
pub(super) struct Line {
    /// Time from which the line is free, microseconds.
    free_us: u64,
}

impl Line {
    pub const fn new() -> Self {
        Self { free_us: 0 }
    }

    /// Frees the line, because the clock has gone back.
    pub const fn clock_went_back(&mut self) {
        self.free_us = 0;
    }

    pub const fn is_free(&self, now_us: u64) -> bool {
        now_us >= self.free_us
    }

    /// Books the sending of `bytes`; with a bandwidth of 0 the line is never free again.
    pub fn send(&mut self, now_us: u64, bytes: usize, bytes_per_s: u32) {
        let micros = (bytes as u64).saturating_mul(1_000_000);
        let duration_us = match bytes_per_s {
            0 => u64::MAX,
            rate => micros.div_ceil(rate.into()),
        };
        let from_us = self.free_us.max(now_us.saturating_sub(CATCH_UP_US));
        self.free_us = from_us.saturating_add(duration_us);
    }
}
