//! Sensors on their SPI buses.

use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use meerkat_mwd::sensors::{
    Mounting, Rm3100Settings,
    blocking::{Ism330dhcx, Rm3100, SpiRegisters, Supervised},
};
use nrf52840_hal::{
    gpio::{Floating, Input, Output, Pin, PushPull},
    pac::{SPIM1, SPIM2},
    spim::{Frequency, MODE_3, Pins, Spim},
};
use st_mems_bus::blocking::spi::SpiBus;

type Out = Pin<Output<PushPull>>;
/// Clock, data in, data out.
type Wires = (Out, Pin<Input<Floating>>, Out);
type Device<SPI> = ExclusiveDevice<Spim<SPI>, Out, NoDelay>;
pub type Inertial = Supervised<Ism330dhcx<SpiBus<Device<SPIM2>>>, 2>;
pub type Magnetic = Supervised<Rm3100<SpiRegisters<Device<SPIM1>>>, 1>;

pub fn inertial(spi: SPIM2, (sck, miso, mosi): Wires, select: Out) -> Inertial {
    let pins = Pins { sck: Some(sck), miso: Some(miso), mosi: Some(mosi) };
    let Ok(device) = ExclusiveDevice::new_no_delay(Spim::new(spi, pins, Frequency::M8, MODE_3, 0), select);
    Supervised::new(Ism330dhcx::new_spi(device, 1), Mounting::ALIGNED)
}

pub fn magnetic(spi: SPIM1, (sck, miso, mosi): Wires, select: Out) -> Magnetic {
    let pins = Pins { sck: Some(sck), miso: Some(miso), mosi: Some(mosi) };
    let Ok(device) = ExclusiveDevice::new_no_delay(Spim::new(spi, pins, Frequency::M1, MODE_3, 0), select);
    Supervised::new(Rm3100::new_spi(device, Rm3100Settings::default()), Mounting::ALIGNED)
}
