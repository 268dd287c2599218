//! Runs without hardware: [`Record`]s of a run, and sensor models at register level, to run real driver code without a
//! sensor: the ST ISM330DHCX and the PNI RM3100 behind `embedded_hal`'s [`SpiDevice`](embedded_hal::spi::SpiDevice) and
//! [`I2c`](embedded_hal::i2c::I2c).
//!
//! A model is played a truth in SI units ([`Sample`](crate::Sample)s, body axes, time passed in) and converts it as
//! the data sheet says: sensitivity, rounding, saturation, output data rate, FIFO, flags. Nothing here knows a
//! driver: every address, bit and sensitivity stands here a second time, with the section that it is from, so that a
//! driver's typing error shows.
//!
//! Not modelled: noise, filters' delays, self-test, interrupts other than data ready, the sensor hub and the
//! machine-learning core.
//!
//! Faults are injected at a numbered transaction: those of the part by its model ([`PartFault`]), those of the wire
//! by a wrapper around any bus ([`FaultyBus`]).
//!
//! A [`ModelledPair`] is both parts with the adapters of [`sensors`](crate::sensors) on them: truth in, samples out,
//! the same on a host and on a chip. A [`RecordingPlayer`] plays a recording through it.

mod at_period;
mod attachment;
mod conversion;
mod fault;
mod faulty_bus;
pub mod ism330dhcx;
mod modelled_pair;
mod record;
mod recording;
pub mod rm3100;
mod serial_part;

pub use at_period::AtPeriod;
pub use attachment::{OnI2c, OnSpi, PartError};
pub use conversion::Conversions;
pub use fault::{Injection, PartFault, Schedule};
pub use faulty_bus::{BusFault, FaultyBus, InjectedError, WireMeter};
pub use ism330dhcx::Ism330dhcx;
pub use modelled_pair::{ModelledPair, ModelledParts, PairError, Periods};
pub use record::{Cost, Record, Summary};
pub use recording::{DITHER, PlayedCounts, Recording, RecordingPlayer};
pub use rm3100::Rm3100;
pub use serial_part::{Cursor, SerialPart};
