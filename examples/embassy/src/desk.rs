//! This machine: a clock that does not wait, so that the run takes as long as its work.

use embassy_futures::yield_now;
use embassy_probe::Clock;
use std::process;

/// The clock.
pub struct Ticks {
    period_us: u32,
    now_us: u64,
}

impl Ticks {
    /// At time 0.
    pub const fn start(period_us: u32) -> Self {
        Self { period_us, now_us: 0 }
    }
}

impl Clock for Ticks {
    async fn tick(&mut self) -> u64 {
        yield_now().await;
        self.now_us += u64::from(self.period_us);
        self.now_us
    }
}

/// Prints the numbers and ends; without them the run has failed.
pub fn end(numbers: Option<[i32; 3]>) -> ! {
    let Some([samples, inclination_mdeg, azimuth_mdeg]) = numbers else { process::exit(1) };
    println!("{samples} {inclination_mdeg} {azimuth_mdeg}");
    process::exit(0)
}
