//! Self-calibrating attitude for measurement-while-drilling probes. The path of a sample, in order:
#![no_std]
#![forbid(unsafe_code)]

pub mod attitude; // propagation, fusion, inclination, azimuth, toolface
pub mod compensation; // gyro model (P, b), accelerometer and magnetometer models
pub mod config; // what a user sets
pub mod identification; // least squares, IMOA, observability, acceptance
pub mod probe;
pub mod sample; // SI units, timestamp, flags // all of it behind `push` and `poll`
#[cfg(feature = "serde")]
pub mod telemetry; // what leaves the firmware

pub use config::Config;
pub use probe::Probe;
pub use sample::{Sample, SampleFlags};
