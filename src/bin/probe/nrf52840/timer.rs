//! TIMER0 as the sample clock: SysTick stands still while this chip sleeps.

use crate::sample_clock;
use cortex_m::peripheral::{NVIC, SCB};
use nrf52840_hal::pac::{Interrupt, TIMER0, interrupt};

/// 16 MHz over 2 to this power: 1 MHz.
const PRESCALER: u8 = 4;
const CYCLES_PER_US: u32 = 64;

/// Starts the timer. It wraps, and its interrupt comes, once a sample period.
pub fn start(timer: TIMER0, period_us: u32) {
    timer.mode.write(|w| w.mode().timer());
    timer.bitmode.write(|w| w.bitmode()._32bit());
    // SAFETY: the fields take these values (product specification, TIMER: PRESCALER 0 to 9, CC any word).
    #[allow(unsafe_code)]
    unsafe {
        timer.prescaler.write(|w| w.prescaler().bits(PRESCALER));
        timer.cc[0].write(|w| w.bits(period_us));
    }
    timer.shorts.write(|w| w.compare0_clear().enabled());
    timer.intenset.write(|w| w.compare0().set());
    // SAFETY: the handler's data stand, and no critical section rests on this interrupt being masked by itself.
    #[allow(unsafe_code)]
    unsafe {
        NVIC::unmask(Interrupt::TIMER0);
    }
    timer.tasks_start.write(|w| w.tasks_start().set_bit());
    critical_section::with(|cs| clock::TIMER.borrow(cs).replace(Some(timer)));
}

/// Microseconds since the start.
pub fn now_us() -> u64 {
    let (rounds, within, period) = clock::read();
    rounds * u64::from(period) + u64::from(within)
}

/// See [`sample_clock::across_a_stall`]; before the clock has started there is nothing to count.
pub fn across_a_stall<R>(stall: impl FnOnce() -> R) -> R {
    match clock::period_us() {
        0 => stall(),
        period_us => sample_clock::across_a_stall(clock::shown_us, (period_us, CYCLES_PER_US), stall),
    }
}

mod clock {
    use super::{TIMER0, sample_clock};
    use core::cell::RefCell;
    use critical_section::Mutex;

    pub static TIMER: Mutex<RefCell<Option<TIMER0>>> = Mutex::new(RefCell::new(None));

    fn of_timer(read: impl Fn(&TIMER0) -> u32) -> u32 {
        critical_section::with(|cs| TIMER.borrow_ref(cs).as_ref().map_or(0, read))
    }

    fn within_us(timer: &TIMER0) -> u32 {
        timer.tasks_capture[1].write(|w| w.tasks_capture().set_bit());
        timer.cc[1].read().bits()
    }

    /// Microseconds of a round; 0 before the start.
    pub fn period_us() -> u32 {
        of_timer(|timer| timer.cc[0].read().bits())
    }

    /// Microseconds of this round, and one round more while the interrupt of the one before waits.
    pub fn shown_us() -> u32 {
        of_timer(|timer| {
            let within = within_us(timer);
            // A round may end between the two reads: then the microseconds of the next one count.
            let waits = timer.events_compare[0].read().events_compare().bit();
            if waits { timer.cc[0].read().bits() + within_us(timer) } else { within }
        })
    }

    /// Returns the rounds, the microseconds in this round, and those of a whole round.
    pub fn read() -> (u64, u32, u32) {
        let (rounds, within) = sample_clock::rounds_and(|| of_timer(within_us));
        (rounds, within, period_us())
    }
}

#[interrupt]
fn TIMER0() {
    critical_section::with(|cs| {
        if let Some(timer) = clock::TIMER.borrow_ref(cs).as_ref() {
            timer.events_compare[0].reset();
        }
    });
    sample_clock::round();
    SCB::set_pendsv();
}
