//! The watchdog that the emulated chip lacks: the sample clock's exception counts it down, and nothing has a higher priority.

use crate::reset_record::{self, Asked};
use core::sync::atomic::{AtomicU32, Ordering};

/// Rounds of the sample clock that a stage may take: a second at 200 Hz.
const ROUNDS: u32 = 200;

static LEFT: AtomicU32 = AtomicU32::new(ROUNDS);

pub fn feed() {
    LEFT.store(ROUNDS, Ordering::Relaxed);
}

/// One round less; resets when none is left.
pub fn count_down() {
    match LEFT.load(Ordering::Relaxed) {
        0 => reset_record::reset(Asked::Watchdog),
        left => LEFT.store(left - 1, Ordering::Relaxed),
    }
}
