//! Messages of a probe, as a host decodes them from frames.

use super::{AttitudeFrame, Boot, BurstPart, Health, Identification, ProgramReport, RawSample};
use crate::{
    diagnosis::DiagnosisReport,
    magnet::HardIronInterval,
    probe::Output,
    survey::{DrillingDynamics, SlidingToolface, SurveyReport, VibrationDose},
    telemetry::{Acknowledgement, Frame, Kind},
};
use serde::de::DeserializeOwned;

/// Message of a probe.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Message {
    /// State that the probe starts with.
    Boot(Boot),
    /// Angles of one sample.
    Attitude(AttitudeFrame),
    /// All bits of one sample's output.
    Output(Output),
    /// One raw sample.
    Sample(RawSample),
    /// A survey.
    Survey(SurveyReport),
    /// A window of drilling dynamics.
    Dynamics(DrillingDynamics),
    /// Result of a window.
    Identification(Identification),
    /// Effects found by a diagnosis, with its verdict.
    Diagnosis(DiagnosisReport),
    /// Interval in which a magnet was on the probe.
    HardIron(HardIronInterval),
    /// Counters, stack, overruns.
    Health(Health),
    /// Answer to a command.
    Acknowledgement(Acknowledgement),
    /// Toolface while sliding.
    Toolface(SlidingToolface),
    /// Vibration and shocks that the tool has taken so far.
    Dose(VibrationDose),
    /// Part of the raw samples of the second with the most vibration.
    Burst(BurstPart),
    /// The program that runs.
    Program(ProgramReport),
}

/// Reason for which a frame with a right CRC is no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum PayloadError {
    /// The kind belongs to another version, or to frames in the other direction.
    UnknownKind {
        /// Number of the kind.
        kind: u8,
    },
    /// The payload does not fit its kind: another version wrote it.
    Malformed {
        /// Kind of the frame.
        kind: Kind,
    },
}

impl core::fmt::Display for PayloadError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::UnknownKind { kind } => write!(f, "no kind of message has the number {kind}"),
            Self::Malformed { kind } => write!(f, "the payload is no {kind:?} of this version"),
        }
    }
}

impl core::error::Error for PayloadError {}

impl Message {
    /// Returns the kind of the message's frame.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Boot(_) => Kind::Boot,
            Self::Attitude(_) => Kind::Attitude,
            Self::Output(_) => Kind::Output,
            Self::Sample(_) => Kind::Sample,
            Self::Survey(_) => Kind::Survey,
            Self::Dynamics(_) => Kind::Dynamics,
            Self::Identification(_) => Kind::Identification,
            Self::Diagnosis(_) => Kind::Diagnosis,
            Self::HardIron(_) => Kind::HardIron,
            Self::Health(_) => Kind::Health,
            Self::Acknowledgement(_) => Kind::Acknowledgement,
            Self::Toolface(_) => Kind::Toolface,
            Self::Dose(_) => Kind::Dose,
            Self::Burst(_) => Kind::Burst,
            Self::Program(_) => Kind::Program,
        }
    }

    /// Decodes the payload of a frame.
    ///
    /// # Errors
    /// The frame comes from another version, or is a command.
    pub fn decode(frame: &Frame<'_>) -> Result<Self, PayloadError> {
        let unknown = PayloadError::UnknownKind { kind: frame.kind };
        let kind = Kind::of_number(frame.kind).ok_or(unknown)?;
        let bytes = frame.payload;
        match kind {
            Kind::Boot => whole(kind, bytes).map(Self::Boot),
            Kind::Attitude => whole(kind, bytes).map(Self::Attitude),
            Kind::Output => whole(kind, bytes).map(Self::Output),
            Kind::Sample => whole(kind, bytes).map(Self::Sample),
            Kind::Survey => whole(kind, bytes).map(Self::Survey),
            Kind::Dynamics => whole(kind, bytes).map(Self::Dynamics),
            Kind::Identification => whole(kind, bytes).map(Self::Identification),
            Kind::Diagnosis => whole(kind, bytes).map(Self::Diagnosis),
            Kind::HardIron => whole(kind, bytes).map(Self::HardIron),
            Kind::Health => whole(kind, bytes).map(Self::Health),
            Kind::Acknowledgement => whole(kind, bytes).map(Self::Acknowledgement),
            Kind::Toolface => whole(kind, bytes).map(Self::Toolface),
            Kind::Dose => whole(kind, bytes).map(Self::Dose),
            Kind::Burst => whole(kind, bytes).map(Self::Burst),
            Kind::Program => whole(kind, bytes).map(Self::Program),
            Kind::Command | Kind::AuthenticatedCommand | Kind::ImagePart => Err(unknown),
        }
    }
}

/// Formats only the message's kind.
#[cfg(all(feature = "defmt", target_os = "none"))]
impl defmt::Format for Message {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}", self.kind());
    }
}

/// Decodes a value that takes all the bytes.
fn whole<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<T, PayloadError> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        _ => Err(PayloadError::Malformed { kind }),
    }
}
