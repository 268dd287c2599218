//! SysTick as a counter of executed instructions.
//!
//! Under `-icount` the emulator's clock advances by the same amount with every instruction and with nothing else, so
//! a timer counts instructions. How many ticks one takes is measured at the start with a loop of known length. The
//! timer has 24 bits (1.5 million instructions): its exception counts how often they wrap, and adds its own ten
//! instructions each time.

use super::fault::Fault;
use core::sync::atomic::{AtomicU32, Ordering, compiler_fence};
use cortex_m::{
    asm,
    peripheral::{SYST, syst::SystClkSource},
};
use cortex_m_rt::exception;
use meerkat_mwd::emulation::Cost;

const WRAP_BITS: u32 = 24;
const RELOAD: u32 = (1 << WRAP_BITS) - 1;

static WRAPS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    // A load and a store: nothing preempts this handler, and nobody else writes.
    WRAPS.store(WRAPS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

pub struct InstructionCounter {
    /// Ticks of `CALIBRATION` instructions.
    calibration_ticks: u64,
    /// Ticks that `measure` itself takes.
    overhead_ticks: u64,
}

/// Instructions of the calibration loop, which begins with the timer's round and ends before it.
const CALIBRATION: u64 = 1_000_000;
/// Instructions of a loop over several rounds, which must come out in proportion.
const CHECK: u64 = 8_000_000;

impl InstructionCounter {
    /// Starts the timer, which then belongs to the counter, and calibrates it.
    pub fn start(mut timer: SYST) -> Result<Self, Fault> {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();

        let mut counter = Self { calibration_ticks: 0, overhead_ticks: 0 };
        counter.overhead_ticks = counter.measure(|| ()).1;
        let base = delay_ticks(&counter, 0);
        counter.calibration_ticks = delay_ticks(&counter, CALIBRATION).saturating_sub(base);
        let check = counter.instructions(delay_ticks(&counter, CHECK).saturating_sub(base));
        if counter.calibration_ticks > 0 && check.abs_diff(CHECK) < CHECK / 10_000 {
            Ok(counter)
        } else {
            Err(Fault::InstructionCounter)
        }
    }

    /// Returns the result of `work`, and the ticks it took.
    pub fn measure<T>(&self, work: impl FnOnce() -> T) -> (T, u64) {
        let start = now();
        compiler_fence(Ordering::SeqCst);
        let result = work();
        compiler_fence(Ordering::SeqCst);
        (result, now().saturating_sub(start).saturating_sub(self.overhead_ticks))
    }

    /// Ticks as instructions, rounded to the nearest.
    pub fn instructions(&self, ticks: u64) -> u64 {
        let rounded = ticks.saturating_mul(CALIBRATION).saturating_add(self.calibration_ticks / 2);
        rounded.checked_div(self.calibration_ticks).unwrap_or(0)
    }

    pub fn cost(&self, tally: &Tally) -> Cost {
        Cost {
            calls: tally.calls,
            instructions: self.instructions(tally.ticks),
            instructions_max: self.instructions(tally.ticks_max),
        }
    }

    pub fn ticks_per_1000_instructions(&self) -> u32 {
        (self.calibration_ticks / (CALIBRATION / 1000)) as u32
    }
}

/// Ticks of all measured calls of one function.
#[derive(Clone, Copy, Default)]
pub struct Tally {
    calls: u64,
    ticks: u64,
    ticks_max: u64,
}

impl Tally {
    pub fn add(&mut self, ticks: u64) {
        self.calls += 1;
        self.ticks += ticks;
        if ticks > self.ticks_max {
            self.ticks_max = ticks;
        }
    }

    /// Ticks since an earlier state of the same tally.
    pub fn since(&self, earlier: &Self) -> u64 {
        self.ticks.saturating_sub(earlier.ticks)
    }
}

/// `asm::delay` is a loop of two instructions.
fn delay_ticks(counter: &InstructionCounter, instructions: u64) -> u64 {
    counter.measure(|| asm::delay((instructions / 2) as u32)).1
}

/// The timer's ticks, counting up, of its 24 bits.
pub fn ticks() -> u32 {
    RELOAD - SYST::get_current()
}

/// Ticks since the start. Never inlined: every reading then costs the same.
#[inline(never)]
fn now() -> u64 {
    loop {
        let wraps = WRAPS.load(Ordering::Relaxed);
        let down = SYST::get_current();
        asm::isb();
        if WRAPS.load(Ordering::Relaxed) == wraps {
            // The timer counts down and its exception comes as it reaches zero: zero is the first tick of a round.
            let up = ((1 << WRAP_BITS) - down) & RELOAD;
            return (u64::from(wraps) << WRAP_BITS) | u64::from(up);
        }
    }
}
