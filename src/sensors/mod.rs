//! Sensors on the bus: drivers, vendor adapters, burst sources, and the combiner of a pair of sources into
//! samples.
//!
//! ```text
//! Part         one file per driver or adapter: registers -> codes
//!   v
//! Supervised   times, SI units, mounting, clip and fault flags; survives resets, overruns, dead buses, frozen outputs
//!   v
//! InertialSource, MagneticSource   time-stamped readings in bursts
//!   v
//! Combiner     -> Sample, for `Probe::push`
//! ```
//! Parts and sources exist in [`blocking`] and [`asynchronous`], from one source text (the BMI088 only blocking).
//! `docs/sensors.md` shows how to write another adapter.

mod combiner;
mod counters;
mod error;
mod frame;
mod frozen;
mod innovation;
#[cfg(feature = "lsm6dsv320x")]
mod lsm6dsv320x_range;
mod mounting;
mod mounting_check;
mod part_data;
mod reading;
mod recovery;
#[cfg(feature = "rm3100")]
mod rm3100_settings;
mod sample_clock;
mod scaled;
#[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x"))]
mod st_fifo;
mod supervision;

pub use combiner::Combiner;
pub use counters::{Condition, Counters};
pub use error::{ReadError, StartError};
pub use frame::{BURST_FRAMES, Burst, Frame, StartStep};
#[cfg(feature = "lsm6dsv320x")]
pub use lsm6dsv320x_range::Lsm6dsv320xRange;
pub use mounting::{Axis, Mounting, MountingError};
pub use mounting_check::MountingCheck;
pub use part_data::{InertialData, MagneticData, PartData, SensorData, TemperatureData};
pub use reading::{InertialReading, MagneticReading};
#[cfg(feature = "rm3100")]
pub use rm3100_settings::{CycleCountError, Rm3100Rate, Rm3100Settings};
pub use sample_clock::Trigger;
use scaled::Scaled;

/// Sources over embedded-hal.
#[path = "."]
pub mod blocking {
    use bisync2::synchronous::bisync;
    #[cfg(feature = "bus")]
    use embedded_hal::{
        i2c::{I2c, Operation as I2cOperation},
        spi::{Operation as SpiOperation, SpiDevice},
    };

    #[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "iis2mdc"))]
    use st_mems_bus::blocking::{BusOperation, i2c::I2cBus, spi::SpiBus};

    #[cfg(feature = "bmi088")]
    mod bmi088;
    #[cfg(feature = "icm42688")]
    mod icm42688;
    #[cfg(feature = "iis2mdc")]
    mod iis2mdc;
    #[cfg(feature = "ism330dhcx")]
    mod ism330dhcx;
    #[cfg(feature = "lsm6dsv320x")]
    mod lsm6dsv320x;
    mod part;
    #[cfg(feature = "bus")]
    mod registers;
    #[cfg(feature = "rm3100")]
    mod rm3100;
    mod source;
    #[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x"))]
    mod st_frames;
    #[cfg(any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "iis2mdc"))]
    mod st_start;
    mod supervised;

    #[cfg(feature = "bmi088")]
    pub use bmi088::Bmi088;
    #[cfg(feature = "icm42688")]
    pub use icm42688::Icm42688;
    #[cfg(feature = "iis2mdc")]
    pub use iis2mdc::Iis2mdc;
    #[cfg(feature = "ism330dhcx")]
    pub use ism330dhcx::Ism330dhcx;
    #[cfg(feature = "lsm6dsv320x")]
    pub use lsm6dsv320x::Lsm6dsv320x;
    pub use part::Part;
    #[cfg(feature = "bus")]
    pub use registers::{I2cRegisters, Registers, SpiRegisters};
    #[cfg(feature = "rm3100")]
    pub use rm3100::Rm3100;
    pub use source::{InertialSource, MagneticSource};
    pub use supervised::Supervised;
}

/// Sources over embedded-hal-async.
#[path = "."]
#[allow(clippy::duplicate_mod)] // The files of `blocking`, here with their `async`.
pub mod asynchronous {
    use bisync2::asynchronous::bisync;
    #[cfg(feature = "async")]
    use embedded_hal_async::{
        i2c::{I2c, Operation as I2cOperation},
        spi::{Operation as SpiOperation, SpiDevice},
    };

    #[cfg(all(feature = "async", any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "iis2mdc")))]
    use st_mems_bus::asynchronous::{BusOperation, i2c::I2cBus, spi::SpiBus};

    #[cfg(all(feature = "async", feature = "icm42688"))]
    mod icm42688;
    #[cfg(all(feature = "async", feature = "iis2mdc"))]
    mod iis2mdc;
    #[cfg(all(feature = "async", feature = "ism330dhcx"))]
    mod ism330dhcx;
    #[cfg(all(feature = "async", feature = "lsm6dsv320x"))]
    mod lsm6dsv320x;
    mod part;
    #[cfg(feature = "async")]
    mod registers;
    #[cfg(all(feature = "async", feature = "rm3100"))]
    mod rm3100;
    mod source;
    #[cfg(all(feature = "async", any(feature = "ism330dhcx", feature = "lsm6dsv320x")))]
    mod st_frames;
    #[cfg(all(feature = "async", any(feature = "ism330dhcx", feature = "lsm6dsv320x", feature = "iis2mdc")))]
    mod st_start;
    mod supervised;

    #[cfg(all(feature = "async", feature = "icm42688"))]
    pub use icm42688::Icm42688;
    #[cfg(all(feature = "async", feature = "iis2mdc"))]
    pub use iis2mdc::Iis2mdc;
    #[cfg(all(feature = "async", feature = "ism330dhcx"))]
    pub use ism330dhcx::Ism330dhcx;
    #[cfg(all(feature = "async", feature = "lsm6dsv320x"))]
    pub use lsm6dsv320x::Lsm6dsv320x;
    pub use part::Part;
    #[cfg(feature = "async")]
    pub use registers::{I2cRegisters, Registers, SpiRegisters};
    #[cfg(all(feature = "async", feature = "rm3100"))]
    pub use rm3100::Rm3100;
    pub use source::{InertialSource, MagneticSource};
    pub use supervised::Supervised;
}
