//! One raw sample of a recording.

use super::Payload;
use crate::{sample::Sample, telemetry::Kind};
use serde::{Deserialize, Serialize};

/// One sample of a recording: the input of [`Probe::push`](crate::Probe::push), to the last bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawSample {
    /// Number of samples before it since the start. A number that is missing was lost on the way.
    pub number: u32,
    /// The sample.
    pub sample: Sample,
}

impl RawSample {
    /// Makes the sample as the pipeline takes it, [`Sample::sanitised`]: without NaN and infinity, which a text file
    /// cannot hold.
    #[must_use]
    pub fn of(number: u32, sample: &Sample) -> Self {
        Self { number, sample: sample.sanitised() }
    }
}

impl Payload for RawSample {
    const KIND: Kind = Kind::Sample;
}
