//! Payloads of the frames, one kind each. Each is defined once, for the probe that writes it and the host that reads
//! it.

mod attitude_frame;
mod boot;
mod burst_part;
mod health;
mod identification;
mod message;
mod probe_id;
mod program;
mod raw_sample;

pub use attitude_frame::{AttitudeFrame, CompactAngles};
pub use boot::{Boot, ResetReason};
pub use burst_part::BurstPart;
pub use health::{Health, SelfTest};
pub use identification::Identification;
pub use message::{Message, PayloadError};
pub use probe_id::ProbeId;
pub use program::{ImagePart, ProgramReport};
pub use raw_sample::RawSample;

use crate::{
    diagnosis::DiagnosisReport,
    magnet::HardIronInterval,
    probe::Output,
    survey::{DrillingDynamics, SlidingToolface, SurveyReport, VibrationDose},
    telemetry::Kind,
};

/// Value that is sent in a frame of its own kind.
pub trait Payload: serde::Serialize {
    /// Kind of its frame.
    const KIND: Kind;
}

impl Payload for Output {
    const KIND: Kind = Kind::Output;
}
impl Payload for SurveyReport {
    const KIND: Kind = Kind::Survey;
}
impl Payload for DrillingDynamics {
    const KIND: Kind = Kind::Dynamics;
}
impl Payload for SlidingToolface {
    const KIND: Kind = Kind::Toolface;
}
impl Payload for VibrationDose {
    const KIND: Kind = Kind::Dose;
}
impl Payload for DiagnosisReport {
    const KIND: Kind = Kind::Diagnosis;
}
impl Payload for HardIronInterval {
    const KIND: Kind = Kind::HardIron;
}
