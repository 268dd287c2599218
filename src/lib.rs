//! Self-calibrating attitude for measurement-while-drilling probes. The path of a sample, in order:
#![no_std]
#![forbid(unsafe_code)]
#![deny(clippy::indexing_slicing)]

pub mod sensors; // drivers and adapters -> bursts of readings -> samples
pub mod sample; // SI units, timestamp, flags
pub mod compensation; // gyro model (P, b), accelerometer and magnetometer models
pub mod attitude; // propagation, fusion, inclination, azimuth, toolface
pub mod survey; // stationary and rotating surveys, their quality, drilling dynamics
mod window; // increments, weak-form equations, nodes, rests
mod objective; // what a candidate is worth on a window
pub mod optimizer; // IMOA and others, over any cost
pub mod diagnosis; // residual -> evidence -> missing effect
pub mod identification; // least squares -> search -> observability -> acceptance
pub mod probe; // all of it behind `push` and `poll`
#[cfg(feature = "serde")]
pub mod telemetry; // what leaves the firmware
#[cfg(feature = "storage")]
pub mod storage; // what outlives the power

#[cfg(feature = "sensor-models")]
pub mod sensor_models; // sensors at register level, for runs without a sensor

mod algebra;
pub mod config;
/// The detector of rests that identification learns the gyro's bias by, for a calibration from rests.
pub mod rest {
    pub use crate::window::{Reading, Rest, RestDetector, RestLimits};
}
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
