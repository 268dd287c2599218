//! Self-calibrating attitude for measurement-while-drilling probes. The path of a sample, in order:
//!
//! 1. [`sensors`]: drivers and adapters, bursts of readings to samples
//! 2. [`sample`]: SI units, time, flags; in the body frame
//! 3. [`compensation`]: gyro model (P, b), accelerometer and magnetometer models
//! 4. [`attitude`]: propagation, fusion, inclination, azimuth, toolface
//! 5. [`survey`]: stationary and rotating surveys, their quality, drilling dynamics
//! 6. [`estimator`]: P, b and their uncertainty from all samples so far
//! 7. [`optimizer`]: IMOA and others, over any cost
//! 8. [`identification`]: when what has been learnt flies, and what the search adds to it
//! 9. [`diagnosis`]: which effects the evidence wants, and what is left
//! 10. [`magnet`]: a magnet that came or left
//! 11. [`probe`]: all of it behind `push` and `poll`
//! 12. `telemetry` (feature `serde`): what leaves the firmware; `storage` (feature `storage`): what outlives the power
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::indexing_slicing)]

pub mod attitude;
pub mod compensation;
pub mod diagnosis;
pub mod estimator;
pub mod identification;
pub mod magnet;
pub mod optimizer;
pub mod probe;
pub mod rest;
pub mod sample;
pub mod sensors;
#[cfg(feature = "storage")]
pub mod storage;
pub mod survey;
#[cfg(feature = "serde")]
pub mod telemetry;

#[cfg(feature = "sensor-models")]
pub mod sensor_models; // sensors at register level, for runs without a sensor

mod algebra;
pub mod config;
pub mod equations; // documentation: the paper's equations and our reading of each
mod rotation;

pub use config::Config;
pub use probe::Probe;
pub use sample::{Sample, SampleFlags};

/// The code of the README and of the guides is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
#[doc = include_str!("../docs/effects.md")]
#[cfg_attr(feature = "bus", doc = include_str!("../docs/sensors.md"))]
pub struct Readme;
