//! The watchdog that the emulated chip lacks: the sample clock's exception counts it down, and nothing has a higher
//! priority.

use crate::reset_record::{self, Asked};
use core::sync::atomic::{AtomicU32, Ordering};

/// Longest time without a feed, microseconds: that of the fastest watchdog of a real board.
const PATIENCE_US: u32 = 1_000_000;

/// That time in rounds of the sample clock, and the rounds left until the reset.
static ROUNDS: AtomicU32 = AtomicU32::new(0);
static LEFT: AtomicU32 = AtomicU32::new(0);

/// Starts the watchdog. Call it before the sample clock starts.
pub fn start(period_us: u32) {
    ROUNDS.store(PATIENCE_US.checked_div(period_us).unwrap_or(0), Ordering::Relaxed);
    feed();
}

pub fn feed() {
    #[cfg(feature = "board-updatable")]
    super::apb_watchdog::feed();
    LEFT.store(ROUNDS.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// Counts a round; resets when none is left.
pub fn count_down() {
    match LEFT.load(Ordering::Relaxed) {
        0 => reset_record::reset(Asked::Watchdog),
        left => LEFT.store(left - 1, Ordering::Relaxed),
    }
}
