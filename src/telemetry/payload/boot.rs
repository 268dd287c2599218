//! State that a probe starts with, and why it started.

use super::{Payload, ProbeId};
use crate::{config::Config, storage::StoredModel, telemetry::Kind};
use serde::{Deserialize, Serialize};

/// State that the probe starts with. It is sent at the start and before a recording, which is replayed with this
/// configuration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Boot {
    /// Version of frame kinds and payloads; see [`Boot::PROTOCOL`].
    pub protocol: u16,
    /// Unique number of the probe.
    pub probe: ProbeId,
    /// Version of the firmware: major, minor, patch.
    pub version: [u8; 3],
    /// Reason of the start.
    pub reset: ResetReason,
    /// Resets by the watchdog since power came.
    pub watchdog_resets: u32,
    /// Number of the stored model that flies from the start; `None` for the factory's.
    pub restored_model: Option<u32>,
    /// Seconds of motion that the estimator had learnt from when that model was stored, and continues from; `None` if
    /// it starts from its prior.
    pub goes_on_after_s: Option<f32>,
    /// Number of the first sample since the pipeline started afresh: with the program, or on a command that changes
    /// calibration.
    pub first_sample: u32,
    /// The configuration, with the factory's model.
    pub config: Config,
    /// Model that flies instead of the factory's; `None` if the factory's flies.
    pub flies: Option<StoredModel>,
}

impl Boot {
    /// Version of the protocol that this library speaks. It changes with every field that is added, removed or
    /// reordered.
    pub const PROTOCOL: u16 = 13;

    /// Version of this library.
    pub const VERSION: [u8; 3] = [
        decimal(env!("CARGO_PKG_VERSION_MAJOR")),
        decimal(env!("CARGO_PKG_VERSION_MINOR")),
        decimal(env!("CARGO_PKG_VERSION_PATCH")),
    ];

    /// Boot of this library after power-on, with the factory's model.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self {
            protocol: Self::PROTOCOL,
            probe: ProbeId([0; 12]),
            version: Self::VERSION,
            reset: ResetReason::PowerOn,
            watchdog_resets: 0,
            restored_model: None,
            goes_on_after_s: None,
            first_sample: 0,
            config,
            flies: None,
        }
    }
}

const fn decimal(text: &str) -> u8 {
    match u8::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => u8::MAX,
    }
}

/// Reason of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum ResetReason {
    /// Power came.
    PowerOn,
    /// The watchdog was not fed.
    Watchdog,
    /// The firmware asked for it.
    Software,
    /// The reset pin.
    Pin,
    /// Power sagged.
    BrownOut,
    /// The chip does not state a reason.
    Unknown,
    /// A panic or a hard fault.
    Fault,
}

impl Payload for Boot {
    const KIND: Kind = Kind::Boot;
}
