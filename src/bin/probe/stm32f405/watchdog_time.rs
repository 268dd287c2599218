//! Time of the watchdog. It has to outlast an erasure, in which the program stands still.

/// Time at the nominal 32 kHz of the watchdog's oscillator, milliseconds.
pub const WATCHDOG_MS: u32 = 1_500;
/// Shortest time: the oscillator has 17 to 47 kHz (DS8626, low-speed internal RC oscillator), so that the watchdog
/// waits for 1.02 to 2.82 s.
pub const SHORTEST_MS: u32 = WATCHDOG_MS * 32 / 47;
/// Longest call of `ModelStore::prepare`, milliseconds: its timing budget.
pub const PREPARATION_MS: u32 = 700;
const _: () = assert!(SHORTEST_MS > PREPARATION_MS, "the fastest watchdog has to outlast an erasure");
