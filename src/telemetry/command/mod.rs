//! What a host may ask of the probe.
//!
//! A command is a frame of [`Kind::Command`], or of [`Kind::AuthenticatedCommand`] with a counter and a message authentication code before
//! it. A [`CommandGate`] decides; the firmware does what it lets through and answers every frame with an [`Acknowledgement`].

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
use crate::config::{Config, ConfigError, SurveyConfig};
use serde::{Deserialize, Serialize};

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[expect(
    clippy::large_enum_variant,
    reason = "nothing here can be boxed, and a command lives only until it is carried out"
)]
#[non_exhaustive]
pub enum Command {
    /// Look at what the sensors read and read the storage anew, and report health with what was found. Not while drilling: only at rest
    /// is it known what a sensor should read, and the storage takes a while. The parts are not excited: their own self-tests are not run.
    SelfTest,
    /// What goes over the line, and how fast. Needs the key: it can silence the probe.
    ConfigureStream(StreamConfig),
    /// Send every raw sample from now on, the boot configuration first. Attitudes go on between the samples.
    StartRecording {
        /// For so long, seconds, 1 to 604,800; `None`: until it is stopped.
        for_s: Option<u32>,
    },
    /// End the recording; one that was begun with the key only with the key.
    StopRecording,
    /// Take a survey at the next rest.
    StationarySurvey {
        /// How long the request stands, seconds; 1 to 3,600.
        within_s: u16,
    },
    /// Start afresh with another configuration. Changes calibration.
    Configure(Config),
    /// How surveys are taken and judged. Changes calibration: a toolface offset is one.
    ConfigureSurvey(SurveyConfig),
    /// Store what a window gave, and fly it where its acceptance refused it: a fit that somebody has looked at and believes, from the start of
    /// the next run on, too. Of a window that was accepted, what flies is stored without waiting for it to prove stable. Only the latest
    /// window that could look can be had (too little motion or sensors that cannot judge leave one that could not), and only while the
    /// effects are those that it was fitted with. The limits that every stored model has to keep hold here, too. To fly it the pipeline
    /// starts afresh. Changes calibration.
    AcceptModel {
        /// End of the window, microseconds, as its report says: what is accepted is what was looked at.
        window_end_us: u64,
    },
    /// Fly an earlier model, now and after every start, and restore no other that is stored, of any temperature: what was rolled back may be
    /// in all of them. The pipeline then starts afresh. Changes calibration.
    RollBackModel {
        /// Which.
        to: EarlierModel,
    },
    /// Erase stored models; what flies goes on. Changes calibration.
    Erase {
        /// Which.
        what: Erasure,
    },
}

/// A model that flew before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum EarlierModel {
    /// The one before the one that flies: before P or the list of effects changed last, or, where nothing has changed since the start, the
    /// one that was stored before the one that was restored.
    Previous,
    /// The factory's.
    Factory,
}

/// What is erased. The factory's calibration never is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Erasure {
    /// All accepted models.
    Models,
}

impl Command {
    /// Whether it changes what attitude is computed with: it then needs authentication, and the tool must not be drilling.
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
            | Self::StationarySurvey { .. } => false,
        }
    }

    /// Whether it needs authentication: what changes calibration does, and what can silence the probe.
    #[must_use]
    pub const fn needs_the_key(&self) -> bool {
        self.changes_calibration() || matches!(self, Self::ConfigureStream(_))
    }

    /// Whether the probe sends more for it than an answer, once: a boot, a survey or its health.
    #[must_use]
    pub const fn asks_for_a_report(&self) -> bool {
        matches!(self, Self::SelfTest | Self::StartRecording { .. } | Self::StationarySurvey { .. })
    }

    /// Whether it has to wait until the tool is not drilling.
    #[must_use]
    pub const fn needs_a_pause(&self) -> bool {
        self.changes_calibration() || matches!(self, Self::SelfTest)
    }

    /// Checks every number in it; `now_us` is the probe's time.
    ///
    /// # Errors
    /// The first that is out of its bounds.
    pub fn check(&self, now_us: u64) -> Result<(), ConfigError> {
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ConfigError { field, must_be }) };
        match self {
            Self::ConfigureStream(config) => config.validate(),
            Self::Configure(config) => config.validate(),
            Self::ConfigureSurvey(config) => config.validate(),
            Self::StartRecording { for_s } => {
                check(for_s.is_none_or(|s| (1..=604_800).contains(&s)), "for_s", "1 to 604800")
            }
            Self::StationarySurvey { within_s } => check((1..=3_600).contains(within_s), "within_s", "1 to 3600"),
            Self::AcceptModel { window_end_us } => check(*window_end_us <= now_us, "window_end_us", "in the past"),
            Self::SelfTest | Self::StopRecording | Self::RollBackModel { .. } | Self::Erase { .. } => Ok(()),
        }
    }
}

impl Payload for Command {
    const KIND: Kind = Kind::Command;
}
