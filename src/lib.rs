//! Self-calibrating attitude for measurement-while-drilling probes. The path of a sample, in order:
//!
//! 1. [`sensors`]: drivers and adapters; bursts of readings become samples
//! 2. [`sample`]: SI units, time and flags, in the body frame
//! 3. [`compensation`]: gyro model (P, b), accelerometer and magnetometer models, effects
//! 4. [`magnet`]: a magnet that came or left
//! 5. [`attitude`]: strapdown integration and fusion; inclination, azimuth, toolface
//! 6. [`survey`]: stationary and rotating surveys, their quality, drilling dynamics
//! 7. [`estimator`]: P, b and their uncertainty from all samples so far
//! 8. [`optimizer`]: IMOA and other searches, over any cost function
//! 9. [`identification`]: the instants at which learnt models fly, and the search of each window
//! 10. [`diagnosis`]: the effects that the evidence supports, and the remainder
//! 11. [`probe`]: the whole pipeline behind `push` and `poll`
//! 12. `telemetry` (feature `telemetry`; its messages with `serde` alone): frames; `storage` (feature `storage`):
//!     records in flash
//! 13. `application` (feature `application`): the program around the pipeline, on any board
//!
//! # Features
//!
//! None is on by default: the pipeline, the attitude filter, surveys and the optimisers need none.
//!
//! | feature | adds |
//! |---|---|
//! | `serde` | `Serialize` and `Deserialize` of configuration, samples and reports |
//! | `storage` | models, the command counter and the factory's records in flash |
//! | `async-storage` | the storage over an asynchronous flash of `embedded-storage-async` |
//! | `image-slots` | two images of the program in flash, with trial and rollback |
//! | `telemetry` | frames for a line, their queue, the survey word of a mud pulser |
//! | `commands` | commands to the probe, with a keyed authentication code |
//! | `application` | the probe's program over a `Board` |
//! | `bus` | registers over SPI and I2C, for a driver of one's own |
//! | `async` | drivers and adapters over `embedded-hal-async`, too |
//! | `rm3100`, `iis2mdc` | magnetometers: PNI RM3100, ST IIS2MDC |
//! | `ism330dhcx`, `lsm6dsv320x`, `icm42688`, `bmi088` | gyros with accelerometers: ST, TDK ICM-42688-P, Bosch |
//! | `emulation` | register-level models of the ISM330DHCX and the RM3100, with faults, and records of a run |
//! | `baseline-searches` | the searches that IMOA is compared with |
//! | `explanation` | what an update rests on, for tools on a desk |
//! | `defmt` | `defmt::Format` of public enums and errors, on a chip |
//!
//! # In a firmware of one's own
//!
//! The profile of your own program counts, not this crate's. A program on a Cortex-M4F that pushes and polls takes 365
//! KB of flash with the profile below. With `opt-level = "s"` it takes 217 KB, and needs more cycles:
//!
//! ```toml
//! [profile.release]
//! opt-level = 2         # 3: a sixth more flash for 2 % fewer cycles
//! lto = "fat"           # drops what is not called
//! codegen-units = 1
//! panic = "abort"
//! ```
//!
//! and in `.cargo/config.toml`, for a Cortex-M4:
//!
//! ```toml
//! [target.thumbv7em-none-eabihf]
//! rustflags = ["-Ctarget-cpu=cortex-m4", "-Clink-arg=--icf=all"]
//! ```
//!
//! The crate compiles with Rust 1.89 and later; a higher minimum comes with a new minor version. The public interface
//! has types of [`nalgebra`] and [`heapless`], and with the features that need them of `embedded-hal`,
//! `embedded-storage`, their asynchronous forms and `st-mems-bus`: take these crates from here, so that the versions
//! agree.
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::indexing_slicing)]

#[cfg(feature = "application")]
pub mod application;
pub mod attitude;
pub mod compensation;
pub mod diagnosis;
pub mod estimator;
pub mod identification;
pub mod magnet;
pub mod optimizer;
pub mod probe;
pub mod sample;
pub mod sensors;
#[cfg(feature = "storage")]
pub mod storage;
pub mod survey;
#[cfg(feature = "telemetry")]
pub mod telemetry;

#[cfg(feature = "emulation")]
pub mod emulation; // models of sensors and records, for runs without hardware

mod algebra;
mod change;
pub mod config;
pub mod equations; // documentation: the paper's equations, each with our reading
mod fingerprint;
mod rotation;
mod statistics;
mod time_step;
mod units;

pub use config::Config;
/// The bus of the drivers and adapters.
#[cfg(feature = "bus")]
pub use embedded_hal;
/// The bus of the asynchronous drivers and adapters.
#[cfg(feature = "async")]
pub use embedded_hal_async;
/// The flash of the storage.
#[cfg(feature = "storage")]
pub use embedded_storage;
/// The flash of the asynchronous storage.
#[cfg(feature = "async-storage")]
pub use embedded_storage_async;
/// Bounded text and lists of the public interface.
pub use heapless;
/// Vectors and matrices of the public interface.
pub use nalgebra;
pub use probe::Probe;
pub use sample::{Sample, SampleFlags};
/// The bus as ST's adapters take it.
#[cfg(any(feature = "iis2mdc", feature = "ism330dhcx", feature = "lsm6dsv320x"))]
pub use st_mems_bus;

/// Code of the README, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

/// Code of the guide, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../guide/src/rust.md")]
pub struct Guide;

/// Code of the guide's firmware, compiled as a test.
#[cfg(all(doctest, feature = "telemetry"))]
#[doc = include_str!("../guide/src/own_firmware.md")]
pub struct GuideFirmware;

/// Code of the page about sensors, compiled as a test.
#[cfg(all(doctest, feature = "bus"))]
#[doc = include_str!("../docs/sensors.md")]
pub struct GuideSensors;
