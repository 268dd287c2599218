//! Part of the raw samples of the second with the most vibration, which do not fit into one frame.

use super::Payload;
use crate::{survey::BurstSample, telemetry::Kind};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Successive samples of the worst second. Parts come in the order of the samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BurstPart {
    /// Number of the burst's samples before these.
    pub first: u16,
    /// Number of samples in the whole burst.
    pub of: u16,
    /// Root mean square of the whole burst's acceleration about its mean, m/s^2.
    pub rms_m_s2: f32,
    /// The samples, oldest first.
    pub samples: Vec<BurstSample, { BurstPart::SAMPLES }>,
}

impl BurstPart {
    /// Largest number of samples in one part: 190 bytes or so, so that a result which comes meanwhile waits for one
    /// part only.
    pub const SAMPLES: usize = 8;
}

impl Payload for BurstPart {
    const KIND: Kind = Kind::Burst;
}
