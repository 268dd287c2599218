//! Chip-specific part of a board with sensors.

pub use super::{
    acquisition::{Inertial, Magnetic},
    flash::{FactoryFlash, ModelFlash},
    port::wake,
    timer::now_us,
};
use nrf52840_hal::wdt::{WatchdogHandle, handles::Hdl0};

pub type Watchdog = WatchdogHandle<Hdl0>;

pub fn feed(watchdog: &mut Watchdog) {
    watchdog.pet();
}
