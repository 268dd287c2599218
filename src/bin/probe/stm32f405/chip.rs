//! Chip-specific part of a board with sensors.

pub use super::{
    acquisition::{Inertial, Magnetic},
    flash_registers::{FactoryFlash, ModelFlash},
    port::wake,
};
pub use crate::sample_clock::systick::now_us;
pub use stm32f4xx_hal::watchdog::IndependentWatchdog as Watchdog;

pub fn feed(watchdog: &mut Watchdog) {
    watchdog.feed();
}
