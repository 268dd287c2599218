use super::Payload;
use crate::{sample::Sample, telemetry::Kind};
use serde::{Deserialize, Serialize};

/// One sample of a recording: what went into [`Probe::push`](crate::Probe::push), to the last bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawSample {
    /// How many samples came before it since the start. What is missing in a recording was lost on the way.
    pub number: u32,
    /// The sample.
    pub sample: Sample,
}

impl RawSample {
    /// The sample as the pipeline takes it: [`Sample::sanitised`], which a text can hold.
    #[must_use]
    pub fn of(number: u32, sample: &Sample) -> Self {
        Self { number, sample: sample.sanitised() }
    }
}

impl Payload for RawSample {
    const KIND: Kind = Kind::Sample;
}
