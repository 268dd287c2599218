//! The watchdog that the emulated chip lacks: the sample clock's exception counts it down, and nothing has a higher
//! priority.

use crate::reset_record::{self, Asked};
use core::sync::atomic::{AtomicU32, Ordering};

/// Longest round of the program, microseconds: that of the fastest watchdog of a real board.
const PATIENCE_US: u32 = 1_000_000;

/// The same in rounds of the sample clock, and those that are left.
static ROUNDS: AtomicU32 = AtomicU32::new(0);
static LEFT: AtomicU32 = AtomicU32::new(0);

/// Before the sample clock.
pub fn start(period_us: u32) {
    ROUNDS.store(PATIENCE_US.checked_div(period_us).unwrap_or(0), Ordering::Relaxed);
    feed();
}

pub fn feed() {
    LEFT.store(ROUNDS.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// One round less; resets when none is left.
pub fn count_down() {
    match LEFT.load(Ordering::Relaxed) {
        0 => reset_record::reset(Asked::Watchdog),
        left => LEFT.store(left - 1, Ordering::Relaxed),
    }
}
