//! Sensors on their SPI buses.

use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use meerkat_mwd::sensors::{
    Mounting, Rm3100Settings,
    blocking::{Ism330dhcx, Rm3100, SpiRegisters, Supervised},
};
use st_mems_bus::blocking::spi::SpiBus;
use stm32f4xx_hal::{
    gpio::{Output, PA4, PA5, PA6, PA7, PB12, PB13, PB14, PB15, Speed},
    pac::{SPI1, SPI2},
    prelude::*,
    rcc::Rcc,
    spi::{Mode, Phase, Polarity, Spi},
};

type Device<SPI, SELECT> = ExclusiveDevice<Spi<SPI>, SELECT, NoDelay>;
pub type Inertial = Supervised<Ism330dhcx<SpiBus<Device<SPI1, PA4<Output>>>>, 2>;
pub type Magnetic = Supervised<Rm3100<SpiRegisters<Device<SPI2, PB12<Output>>>>, 1>;

/// Clock idle high, data taken at its second edge: mode 3, which both parts take.
const MODE_3: Mode = Mode { polarity: Polarity::IdleHigh, phase: Phase::CaptureOnSecondTransition };

/// Clocks of the buses: 84 MHz over 16 and 42 MHz over 64. The parts take 10 and 1 MHz at most, and the chip divides by
/// powers of two alone; asked for a clock between, the HAL takes the faster one.
const ACCEL_GYRO_HZ: u32 = 5_250_000;
const MAG_HZ: u32 = 656_250;

pub fn inertial(spi: SPI1, (sck, miso, mosi): (PA5, PA6, PA7), select: PA4, rcc: &mut Rcc) -> Inertial {
    let sck = sck.into_alternate().speed(Speed::VeryHigh);
    let mosi = mosi.into_alternate().speed(Speed::VeryHigh);
    let bus = Spi::new(spi, (Some(sck), Some(miso), Some(mosi)), MODE_3, ACCEL_GYRO_HZ.Hz(), rcc);
    let Ok(device) = ExclusiveDevice::new_no_delay(bus, select.into_push_pull_output());
    Supervised::new(Ism330dhcx::new_spi(device, 1), Mounting::ALIGNED)
}

pub fn magnetic(spi: SPI2, (sck, miso, mosi): (PB13, PB14, PB15), select: PB12, rcc: &mut Rcc) -> Magnetic {
    let bus = Spi::new(spi, (Some(sck), Some(miso), Some(mosi)), MODE_3, MAG_HZ.Hz(), rcc);
    let Ok(device) = ExclusiveDevice::new_no_delay(bus, select.into_push_pull_output());
    Supervised::new(Rm3100::new_spi(device, Rm3100Settings::default()), Mounting::ALIGNED)
}
