use super::Payload;
use crate::{identification::WindowReport, telemetry::Kind};
use serde::{Deserialize, Serialize};

/// What came of one window, with its reason.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// The report.
    pub report: WindowReport,
    /// Mean temperature of the window, degrees Celsius; `None`: not known.
    pub temperature_c: Option<f32>,
}

impl Payload for Identification {
    const KIND: Kind = Kind::Identification;
}
