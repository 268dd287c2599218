//! Commands of a host to the probe.
//!
//! A command is a frame of [`Kind::Command`], or of [`Kind::AuthenticatedCommand`] with a counter and a message
//! authentication code before it. A [`CommandGate`] decides; the firmware carries out the commands that it passes and
//! answers with an [`Acknowledgement`].

mod acknowledgement;
#[cfg(feature = "commands")]
mod allowance;
#[cfg(feature = "commands")]
mod authentication;
#[cfg(feature = "commands")]
mod counter_store;
#[cfg(feature = "commands")]
mod gate;
#[cfg(feature = "commands")]
mod recording;

pub use acknowledgement::{Acknowledgement, CommandRefusal, FieldName, Outcome};
#[cfg(feature = "commands")]
pub use authentication::{Key, authenticate};
#[cfg(feature = "commands")]
pub use counter_store::CounterStore;
#[cfg(feature = "commands")]
pub use gate::{CommandCounters, CommandGate, Judgement, MAX_COUNTER_STEP, Situation};
#[cfg(feature = "commands")]
pub use recording::Recording;

use super::{Kind, Payload, StreamConfig};
use crate::{
    config::{Config, ConfigError, SurveyConfig, check},
    storage::FactoryRecord,
};
use serde::{Deserialize, Serialize};

/// Command to the probe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[expect(
    clippy::large_enum_variant,
    reason = "nothing here can be boxed, and a command lives only until it is carried out"
)]
#[non_exhaustive]
pub enum Command {
    /// Check the sensors' readings, read the storage anew, and report health with the findings. It is refused while
    /// drilling: only at rest is it known what a sensor should read, and the storage takes a while. The sensors'
    /// built-in self-tests are not run.
    SelfTest,
    /// Set the stream over the line and its rate. It needs the key, because it can silence the probe.
    ConfigureStream(StreamConfig),
    /// Send every raw sample from now on, the boot configuration first. Attitudes go on between the samples.
    StartRecording {
        /// Length of the recording, seconds, 1 to 604,800; `None` records until it is stopped.
        for_s: Option<u32>,
    },
    /// End the recording. One that was begun with the key ends only with the key.
    StopRecording,
    /// Send the survey of this stop again.
    StationarySurvey {
        /// Validity of the request, seconds, 1 to 3,600.
        within_s: u16,
    },
    /// Start afresh with another configuration, now and after every start, until the factory writes another
    /// calibration or mounting. Changes calibration.
    Configure(Config),
    /// Set how surveys are taken and judged, until the next [`Command::Configure`], after every start, too. It changes
    /// calibration, because a toolface offset is part of it.
    ConfigureSurvey(SurveyConfig),
    /// Store the fit of a window, and fly it even where it was refused: an operator has checked it. It flies after the
    /// next start, too. Of an accepted window the flown model is stored without waiting for it to prove stable. Only
    /// the latest window that could judge can be accepted (one with too little motion, or with sensors that cannot
    /// judge, could not), and only while the effects are those that it was fitted with. The limits for stored models
    /// apply. To fly the fit the pipeline starts afresh. Changes calibration.
    AcceptModel {
        /// End of the window, microseconds, as its report states it, so that the window that was looked at is the one
        /// accepted.
        window_end_us: u64,
    },
    /// Fly an earlier model, now and after every start, and restore no other stored model of any temperature: the
    /// error that is rolled back may be in all of them. The pipeline then starts afresh. Changes calibration.
    RollBackModel {
        /// Earlier model.
        to: EarlierModel,
    },
    /// Erase stored models, and the flown one goes on; or end what commands have set. Changes calibration.
    Erase {
        /// Records to erase.
        what: Erasure,
    },
    /// Write one of the factory's records, once, and fly with it; writing the same record again succeeds and changes
    /// nothing. The command needs no key, for the key is one of these records: once written, it closes the probe to
    /// others. It needs no pause in drilling: a gyro that was never calibrated can make a probe on a bench look as if
    /// it turned.
    Provision {
        /// The record.
        record: FactoryRecord,
        /// Write nothing, only compare with what the probe holds.
        only_check: bool,
    },
    /// Send the dose of vibration and the raw samples of the worst second. It needs the key, because the samples, 5,000
    /// bytes, go before attitudes; and it is refused while drilling, because a worse second could replace the samples
    /// meanwhile.
    SendVibration,
    /// Get ready to receive an image of the program beside the one that runs. It erases what was there, one page
    /// between two samples; until then parts are refused as busy. Only this command has the key in an update's
    /// transfer: the digest in it stands for every byte.
    BeginUpdate {
        /// Number of the image, above those of the images that are there.
        number: u32,
        /// Length, bytes.
        length: u32,
        /// BLAKE2s-256 of the image.
        digest: [u8; 32],
    },
    /// Compare the received image with its digest; the next start takes it on trial. For as long as that takes, a part
    /// of a second, no sample is flown.
    FinishUpdate,
    /// Start anew, as after a loss of power. A new image is tried then; it confirms itself when every stage of the
    /// program has gone on for half a minute, and unless it has, the start after it takes the image before.
    Restart,
}

/// Earlier model to fly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum EarlierModel {
    /// Model before the flown one: before P or the list of effects changed last. Where nothing has changed since the
    /// start, the model that was stored before the restored one.
    Previous,
    /// Factory's model.
    Factory,
}

/// Records to erase. The factory's calibration is never erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Erasure {
    /// All accepted models.
    Models,
    /// Settings of [`Command::Configure`] and [`Command::ConfigureSurvey`]: the next start is with the factory's
    /// configuration. Until then nothing changes, and nothing is erased.
    Settings,
}

impl Command {
    /// Returns the command that these bytes are; `None` for bytes that are none.
    #[inline(never)]
    #[must_use]
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        match postcard::take_from_bytes(bytes) {
            Ok((command, [])) => Some(command),
            _ => None,
        }
    }

    /// Returns true if the command changes the calibration of attitude: it then needs authentication, and the tool
    /// must not be drilling.
    #[must_use]
    pub const fn changes_calibration(&self) -> bool {
        match self {
            Self::Configure(_)
            | Self::ConfigureSurvey(_)
            | Self::AcceptModel { .. }
            | Self::RollBackModel { .. }
            | Self::Erase { .. } => true,
            Self::SelfTest
            | Self::ConfigureStream(_)
            | Self::StartRecording { .. }
            | Self::StopRecording
            | Self::StationarySurvey { .. }
            | Self::Provision { .. }
            | Self::SendVibration
            | Self::BeginUpdate { .. }
            | Self::FinishUpdate
            | Self::Restart => false,
        }
    }

    /// Returns true if the command changes the program that runs.
    #[must_use]
    pub const fn changes_the_program(&self) -> bool {
        matches!(self, Self::BeginUpdate { .. } | Self::FinishUpdate | Self::Restart)
    }

    /// Returns true if the command needs authentication: it changes calibration or the program, or can keep attitudes
    /// from the line.
    #[must_use]
    pub const fn needs_the_key(&self) -> bool {
        self.changes_calibration()
            || self.changes_the_program()
            || matches!(self, Self::ConfigureStream(_) | Self::SendVibration)
    }

    /// Returns true if the probe sends one report beside the answer: a boot, a survey or its health.
    #[must_use]
    pub const fn asks_for_a_report(&self) -> bool {
        matches!(self, Self::SelfTest | Self::StartRecording { .. } | Self::StationarySurvey { .. })
    }

    /// Returns true if the command has to wait until the tool is not drilling. To end what commands have set never
    /// waits: it acts at the next start, and settings by which no rest is recognised must not stay for ever.
    #[must_use]
    pub const fn needs_a_pause(&self) -> bool {
        if matches!(self, Self::Erase { what: Erasure::Settings }) {
            return false;
        }
        self.changes_calibration() || self.changes_the_program() || matches!(self, Self::SelfTest | Self::SendVibration)
    }

    /// Checks every number of the command; `now_us` is the probe's time.
    ///
    /// # Errors
    /// Names the first number that is out of its bounds.
    pub fn check(&self, now_us: u64) -> Result<(), ConfigError> {
        match self {
            Self::ConfigureStream(config) => config.validate(),
            Self::Configure(config) => config.validate(),
            Self::ConfigureSurvey(config) => config.validate(),
            Self::StartRecording { for_s } => {
                check(for_s.is_none_or(|s| (1..=604_800).contains(&s)), "for_s", "1 to 604800")
            }
            Self::StationarySurvey { within_s } => check((1..=3_600).contains(within_s), "within_s", "1 to 3600"),
            Self::AcceptModel { window_end_us } => check(*window_end_us <= now_us, "window_end_us", "in the past"),
            Self::SelfTest
            | Self::StopRecording
            | Self::RollBackModel { .. }
            | Self::Erase { .. }
            | Self::Provision { .. }
            | Self::SendVibration
            | Self::FinishUpdate
            | Self::Restart => Ok(()),
            Self::BeginUpdate { length, .. } => check(*length > 0, "length", "above 0"),
        }
    }
}

impl Payload for Command {
    const KIND: Kind = Kind::Command;
}
