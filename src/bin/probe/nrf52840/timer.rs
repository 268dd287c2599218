//! TIMER0 as the sample clock: SysTick stands still while this chip sleeps.

use crate::sample_clock;
use cortex_m::peripheral::{NVIC, SCB};
use nrf52840_hal::pac::{Interrupt, TIMER0, interrupt};

/// 16 MHz over 2 to this power: 1 MHz.
const PRESCALER: u8 = 4;

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

mod clock {
    use super::{TIMER0, sample_clock};
    use core::cell::RefCell;
    use critical_section::Mutex;

    pub static TIMER: Mutex<RefCell<Option<TIMER0>>> = Mutex::new(RefCell::new(None));

    /// Returns the rounds, the microseconds in this round, and those of a whole round.
    pub fn read() -> (u64, u32, u32) {
        let mut period = 0;
        let (rounds, within) = sample_clock::rounds_and(|| {
            critical_section::with(|cs| match TIMER.borrow_ref(cs).as_ref() {
                Some(timer) => {
                    timer.tasks_capture[1].write(|w| w.tasks_capture().set_bit());
                    timer.cc[1].read().bits()
                }
                None => 0,
            })
        });
        critical_section::with(|cs| {
            if let Some(timer) = TIMER.borrow_ref(cs).as_ref() {
                period = timer.cc[0].read().bits();
            }
        });
        (rounds, within, period)
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
