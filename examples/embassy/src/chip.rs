//! The emulated MPS2: SysTick is the sample clock, and wakes the task that reads.

use crate::{PERIOD_US, run};
use cortex_m::{Peripherals, peripheral::syst::SystClkSource};
use cortex_m_rt::{entry, exception};
use embassy_probe::Clock;
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use semihosting::{eprintln, println, process};

/// Clock of the MPS2's processor, MHz (Arm DAI 0386).
const MHZ: u32 = 25;

/// Time of the last tick, microseconds.
static TICK: Signal<CriticalSectionRawMutex, u64> = Signal::new();

/// The clock.
pub struct Ticks;

impl Clock for Ticks {
    async fn tick(&mut self) -> u64 {
        TICK.wait().await
    }
}

#[entry]
fn main() -> ! {
    let Some(Peripherals { SYST: mut systick, .. }) = Peripherals::take() else { end(None) };
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(MHZ * PERIOD_US - 1);
    systick.clear_current();
    systick.enable_counter();
    systick.enable_interrupt();
    run(Ticks)
}

#[exception]
fn SysTick() {
    static mut NOW_US: u64 = 0;
    *NOW_US += u64::from(PERIOD_US);
    TICK.signal(*NOW_US);
}

/// Prints the numbers and ends; without them the run has failed.
pub fn end(numbers: Option<[i32; 3]>) -> ! {
    let Some([samples, inclination_mdeg, azimuth_mdeg]) = numbers else {
        eprintln!("a sample was lost, or there is no attitude");
        process::exit(1)
    };
    println!("{samples} {inclination_mdeg} {azimuth_mdeg}");
    process::exit(0)
}
