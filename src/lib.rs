//! Self-calibrating attitude for measurement-while-drilling probes. The path of a sample, in order:
//!
//! 1. [`sensors`]: drivers and adapters; bursts of readings become samples
//! 2. [`sample`]: SI units, time and flags, in the body frame
//! 3. [`compensation`]: gyro model (P, b), accelerometer and magnetometer models, effects
//! 4. [`magnet`]: a magnet that came or left
//! 5. [`attitude`]: strapdown integration and fusion; inclination, azimuth, toolface
//! 6. [`survey`]: stationary and rotating surveys, their quality, drilling dynamics
//! 7. [`estimator`]: P, b and their uncertainty from all samples so far
//! 8. [`optimizer`]: IMOA and others, over any cost
//! 9. [`identification`]: the instants at which learnt models fly, and the search of each window
//! 10. [`diagnosis`]: the effects that the evidence supports, and the remainder
//! 11. [`probe`]: the whole pipeline behind `push` and `poll`
//! 12. `telemetry` (feature `serde`): messages of the firmware; `storage` (same name): records in flash
//! 13. `application` (same name): the program around all of it, on any board
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
pub mod rest;
pub mod sample;
pub mod sensors;
#[cfg(feature = "storage")]
pub mod storage;
pub mod survey;
#[cfg(feature = "serde")]
pub mod telemetry;

#[cfg(feature = "sensor-models")]
pub mod sensor_models; // register-level models of sensors, for runs without hardware

mod algebra;
pub mod config;
pub mod equations; // documentation: the paper's equations, each with our reading
mod rotation;
mod statistics;
mod units;

pub use config::Config;
/// Bounded text and lists of the public interface.
pub use heapless;
/// Vectors and matrices of the public interface.
pub use nalgebra;
pub use probe::Probe;
pub use sample::{Sample, SampleFlags};

/// Code of the README, compiled and run as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
