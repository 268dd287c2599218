//! Sensors on the bus: burst sources, drivers and vendor adapters, and what turns a pair of sources into samples.
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
//! Each exists [`blocking`] and [`asynchronous`], from one source text. How to write another adapter: `docs/sensors.md`.

mod counters;
mod error;
mod frame;
mod part_data;
mod reading;

pub use counters::{Condition, Counters};
pub use error::{ReadError, StartError};
pub use frame::{BurstStatus, Frame, StartStep};
pub use part_data::{InertialData, MagneticData, PartData, SensorData, TemperatureData};
pub use reading::{InertialReading, MagneticReading};

/// Sources over embedded-hal.
#[path = "."]
pub mod blocking {
    use bisync2::synchronous::bisync;

    mod part;
    mod source;

    pub use part::Part;
    pub use source::{InertialSource, MagneticSource};
}

/// Sources over embedded-hal-async.
#[path = "."]
#[allow(clippy::duplicate_mod)] // The same text, once with and once without its `async`.
pub mod asynchronous {
    use bisync2::asynchronous::bisync;

    mod part;
    mod source;

    pub use part::Part;
    pub use source::{InertialSource, MagneticSource};
}
