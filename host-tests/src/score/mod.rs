//! Scores against the reference columns of a trace.

use serde::Serialize;

use crate::{flight::Flight, trace::Trace};

/// The `reference` object of the JSON result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Reference {
    /// Rotation error over 2 s, degrees rms.
    pub orientation_2s_rms_deg: PerModel,
    /// The same with one constant delay fitted, degrees rms.
    pub orientation_2s_rms_time_aligned_deg: PerModel,
    /// That delay, milliseconds.
    pub time_alignment_ms: Option<f64>,
    /// Error of the gravity direction carried from rest to rest, degrees.
    pub rest_gravity_deg: PerModel,
    /// Error of the attitude, degrees rms.
    pub attitude_rms_deg: AttitudeRms,
}

/// One figure for each gyro model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PerModel {
    /// Raw rates.
    pub uncompensated: Option<f64>,
    /// P = I, b from the same windows.
    pub bias_only: Option<f64>,
    /// The 12-parameter fit, accepted or not.
    pub twelve_parameters: Option<f64>,
    /// What flies.
    pub with_effects: Option<f64>,
}

/// Attitude error and its two parts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct AttitudeRms {
    /// The whole angle.
    pub total: Option<f64>,
    /// The part about the vertical.
    pub heading: Option<f64>,
    /// The rest.
    pub inclination: Option<f64>,
}

/// Scores a flight from `from_us` on; `None` where the trace has nothing to score against.
#[must_use]
pub fn score(_trace: &Trace, _flight: &Flight, _from_us: u64) -> Option<Reference> {
    None
}
