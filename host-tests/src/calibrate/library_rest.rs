//! The library's rest detector, from its own source: the library keeps it to itself, and a copy of it would drift.

use nalgebra::Vector3;

// What only the library asks of it, nothing here reads.
#[allow(dead_code)]
#[path = "../../../src/window/rest.rs"]
mod rest;

pub(super) use rest::{RestDetector, RestLimits};

/// A sensor's part of one sample, as the detector takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// No reading.
    Missing,
    /// At full scale.
    Clipped,
    /// What the sensor reads.
    Good(Vector3<f32>),
}
