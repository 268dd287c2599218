//! SysTick: the sample clock, time, and the watchdog that the emulated chip lacks.
//!
//! Its exception has the highest priority, so no stage can keep the watchdog from counting. The reading of the sensors is left to PendSV,
//! which has the lowest.

use super::reset_record;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::{
    asm,
    peripheral::{SCB, SYST, scb::SystemHandler, syst::SystClkSource},
};
use cortex_m_rt::exception;

/// The core's clock (the emulator's machine says so).
const TICKS_PER_US: u32 = 168;
/// Rounds of the sample clock that a stage may take: a second at 200 Hz.
const WATCHDOG_ROUNDS: u32 = 200;

static ROUNDS: AtomicU32 = AtomicU32::new(0);
static ROUNDS_HIGH: AtomicU32 = AtomicU32::new(0);
static WATCHDOG: AtomicU32 = AtomicU32::new(WATCHDOG_ROUNDS);

/// Starts the clock; from then on the watchdog counts too.
pub fn start(mut timer: SYST, mut scb: SCB, period_us: u32) {
    // SAFETY: no critical section of this program rests on priorities, only on masking all interrupts.
    #[allow(unsafe_code)]
    unsafe {
        scb.set_priority(SystemHandler::SysTick, 0);
        scb.set_priority(SystemHandler::PendSV, 0xf0);
    }
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(period_us.saturating_mul(TICKS_PER_US).saturating_sub(1));
    timer.clear_current();
    timer.enable_interrupt();
    timer.enable_counter();
}

#[exception]
fn SysTick() {
    // Loads and stores: nothing preempts this handler, and nobody else counts up.
    let rounds = ROUNDS.load(Ordering::Relaxed).wrapping_add(1);
    ROUNDS.store(rounds, Ordering::Relaxed);
    if rounds == 0 {
        ROUNDS_HIGH.store(ROUNDS_HIGH.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }
    reset_record::count_powered_round();
    let left = WATCHDOG.load(Ordering::Relaxed);
    if left == 0 {
        reset_record::note_watchdog();
        SCB::sys_reset();
    }
    WATCHDOG.store(left - 1, Ordering::Relaxed);
    SCB::set_pendsv();
}

pub fn feed_watchdog() {
    WATCHDOG.store(WATCHDOG_ROUNDS, Ordering::Relaxed);
}

/// Rounds since the start.
pub fn rounds() -> u64 {
    at().0
}

/// Microseconds since the start.
pub fn now_us() -> u64 {
    let (rounds, ticks, period) = at();
    (rounds * u64::from(period) + u64::from(ticks)) / u64::from(TICKS_PER_US)
}

/// Rounds, ticks in this round, ticks of a round.
fn at() -> (u64, u32, u32) {
    let period = SYST::get_reload() + 1;
    loop {
        let (high, low) = (ROUNDS_HIGH.load(Ordering::Relaxed), ROUNDS.load(Ordering::Relaxed));
        let down = SYST::get_current();
        asm::isb();
        if (high, low) == (ROUNDS_HIGH.load(Ordering::Relaxed), ROUNDS.load(Ordering::Relaxed)) {
            // The timer counts down and its exception comes as it reaches zero: zero is the first tick of a round.
            let up = if down == 0 { 0 } else { period - down };
            return (u64::from(high) << 32 | u64::from(low), up, period);
        }
    }
}
