//! Report of a window, with its temperature, for the line.

use super::Payload;
use crate::{identification::WindowReport, telemetry::Kind};
use serde::{Deserialize, Serialize};

/// Result of one window, with its reason.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// The report.
    pub report: WindowReport,
    /// Mean temperature of the window, degrees Celsius; `None` if it is not known.
    pub temperature_c: Option<f32>,
}

impl Payload for Identification {
    const KIND: Kind = Kind::Identification;
}
