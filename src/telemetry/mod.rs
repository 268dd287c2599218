//! Telemetry: messages that leave the firmware, and commands that reach it.
//!
//! On a line everything is a frame (`encode_frame`, `FrameDecoder`) around a postcard `Payload`; the probe's
//! `TelemetryQueue` keeps to the line's bandwidth. A mud pulser gets a `SurveyWord`.

mod command;
mod frame;
mod payload;
mod queue;
pub mod survey_word;

pub use command::{Acknowledgement, Command, CommandRefusal, EarlierModel, Erasure, FieldName, Outcome};
#[cfg(feature = "commands")]
pub use command::{
    CommandCounters, CommandGate, CounterStore, Judgement, Key, MAX_COUNTER_STEP, Recording, Situation, authenticate,
};
pub use frame::{
    EncodeError, Frame, FrameDecoder, Kind, LinkCounters, MAX_DECODED, MAX_FRAME, MAX_PAYLOAD, encode_frame,
    encode_payload,
};
pub use payload::{
    AttitudeFrame, Boot, BurstPart, CompactAngles, Health, Identification, ImagePart, Message, Payload, PayloadError,
    ProbeId, ProgramReport, RawSample, ResetReason, SelfTest,
};
pub use queue::{AttitudeFormat, LineCounters, PushError, StreamConfig, TelemetryQueue};
pub use survey_word::SurveyWord;
