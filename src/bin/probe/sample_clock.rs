//! Sample clock: its rounds, counted by its interrupt or after a stall, the time read from them, and the counters of
//! the acquisition that the clock paces.
//!
//! A board's timer goes round once a sample period; its interrupt calls [`round`] and has the highest priority of all.

use core::sync::atomic::{AtomicU32, Ordering};
use meerkat_mwd::application::AcquisitionCounts;

/// Counters of the only acquisition.
pub static COUNTS: AcquisitionCounts = AcquisitionCounts::new();

static ROUNDS: AtomicU32 = AtomicU32::new(0);
static ROUNDS_HIGH: AtomicU32 = AtomicU32::new(0);

/// Counts a round.
pub fn round() {
    // Loads and stores: nothing preempts the interrupt that calls this, and `across_a_stall` masks it.
    let rounds = ROUNDS.load(Ordering::Relaxed).wrapping_add(1);
    ROUNDS.store(rounds, Ordering::Relaxed);
    if rounds == 0 {
        ROUNDS_HIGH.store(ROUNDS_HIGH.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }
}

/// Rounds since the start, and the value of `timer` within the round. Do not call it with interrupts masked: a round
/// that ends meanwhile would not count.
pub fn rounds_and(timer: impl Fn() -> u32) -> (u64, u32) {
    let rounds = || (ROUNDS_HIGH.load(Ordering::Relaxed), ROUNDS.load(Ordering::Relaxed));
    loop {
        let before = rounds();
        let within = timer();
        // The interrupt of a round that has just ended comes here.
        cortex_m::asm::isb();
        if rounds() == before {
            let (high, low) = before;
            return (u64::from(high) << 32 | u64::from(low), within);
        }
    }
}

/// Rounds since the start.
pub fn rounds() -> u64 {
    rounds_and(|| 0).0
}

/// Runs what may stop the core for longer than a round, such as an erasure of the flash that the program runs from. Of
/// the rounds that end meanwhile the interrupt of one alone waits; the others are counted here, before it comes.
/// `shown_us`: the timer within the round, and one round more while its interrupt waits; `period_us`: a round;
/// `cycles_per_us`: of the core's cycle counter, which goes on, for 2^32 cycles at most.
#[cfg(any(feature = "board-stm32f405", feature = "board-nrf52840"))]
pub fn across_a_stall<R>(
    shown_us: impl Fn() -> u32,
    (period_us, cycles_per_us): (u32, u32),
    stall: impl FnOnce() -> R,
) -> R {
    use cortex_m::peripheral::DWT;
    critical_section::with(|_| {
        let (shown_before_us, before) = (shown_us(), DWT::cycle_count());
        let result = stall();
        let passed_us = DWT::cycle_count().wrapping_sub(before) / cycles_per_us;
        let late_us = (shown_before_us + passed_us).saturating_sub(shown_us());
        for _ in 0..(late_us + period_us / 2) / period_us {
            round();
        }
        result
    })
}

/// SysTick as the timer, where it goes on while the core sleeps. 24 bits: up to 99 ms at 168 MHz.
#[cfg(not(feature = "board-nrf52840"))]
pub mod systick {
    #[cfg(feature = "board-stm32f405")]
    use core::sync::atomic::{AtomicBool, Ordering};
    use cortex_m::peripheral::{SCB, SYST, scb::SystemHandler, syst::SystClkSource};

    /// Ticks of the STM32F405 at its highest clock, or of the MPS2.
    const TICKS_PER_US: u32 = if cfg!(feature = "board-updatable") { 25 } else { 168 };

    #[cfg(feature = "board-stm32f405")]
    static IS_STARTED: AtomicBool = AtomicBool::new(false);

    /// Starts SysTick. PendSV, which its handler pends, gets the lowest priority.
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
        #[cfg(feature = "board-stm32f405")]
        IS_STARTED.store(true, Ordering::Relaxed);
    }

    /// Microseconds since the start.
    pub fn now_us() -> u64 {
        let period = SYST::get_reload() + 1;
        let (rounds, ticks) = super::rounds_and(|| ticks_within(period));
        (rounds * u64::from(period) + u64::from(ticks)) / u64::from(TICKS_PER_US)
    }

    /// Ticks of this round.
    fn ticks_within(period: u32) -> u32 {
        // SysTick counts down and its exception comes as it reaches zero: zero is the first tick of a round.
        match SYST::get_current() {
            0 => 0,
            down => period - down,
        }
    }

    /// See [`super::across_a_stall`]; before the clock has started there is nothing to count.
    #[cfg(feature = "board-stm32f405")]
    pub fn across_a_stall<R>(stall: impl FnOnce() -> R) -> R {
        if !IS_STARTED.load(Ordering::Relaxed) {
            return stall();
        }
        let period = SYST::get_reload() + 1;
        let shown_us = || {
            let within = ticks_within(period);
            // A round may end between the two reads: then the ticks of the next one count.
            let within = if SCB::is_pendst_pending() { period + ticks_within(period) } else { within };
            within / TICKS_PER_US
        };
        super::across_a_stall(shown_us, (period / TICKS_PER_US, TICKS_PER_US), stall)
    }
}
