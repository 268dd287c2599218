use std::path::{Path, PathBuf};

use clap::{Subcommand, ValueEnum};
use meerkat_mwd::telemetry::{AttitudeFormat, Command, EarlierModel, Erasure, StreamConfig};
use serde::de::DeserializeOwned;

use crate::failure::Failure;

/// What a probe can be asked for.
#[derive(Debug, Clone, Subcommand)]
pub enum Request {
    /// Try sensors and storage, and report health
    SelfTest,
    /// What goes over the line, and how fast
    Stream {
        /// Send one of so many attitudes; 0 none
        #[arg(long, value_name = "N", default_value_t = StreamConfig::default().attitude_every)]
        every: u16,
        /// Bandwidth
        #[arg(long, value_name = "BYTES_PER_S", default_value_t = StreamConfig::default().bytes_per_s)]
        bandwidth: u32,
        /// An attitude that has waited for longer is not sent, milliseconds
        #[arg(long, value_name = "MS", default_value_t = StreamConfig::default().max_age_us / 1_000)]
        max_age: u32,
        /// All bits of each attitude, instead of angles in 16 bits
        #[arg(long)]
        exact: bool,
    },
    /// Send every raw sample
    StartRecording {
        /// End by itself after so many seconds
        #[arg(long = "for", value_name = "S")]
        for_s: Option<u32>,
    },
    /// End the recording
    StopRecording,
    /// Take a survey at the next rest
    Survey {
        /// How long the request stands, seconds
        #[arg(long, value_name = "S", default_value_t = 600)]
        within: u16,
    },
    /// Start afresh with the configuration of a file; what it does not name takes its default. Needs --key
    Configure {
        /// The configuration
        file: PathBuf,
    },
    /// Take surveys as a file says; what it does not name takes its default. Needs --key
    ConfigureSurvey {
        /// The configuration of surveys
        file: PathBuf,
    },
    /// Fly the model of the latest window, whether or not it was accepted. Needs --key
    AcceptModel {
        /// End of the window, microseconds, as its report says
        window_end_us: u64,
    },
    /// Fly an earlier model. Needs --key
    RollBack {
        /// Which
        to: Earlier,
    },
    /// Erase stored models. Needs --key
    Erase {
        /// Which
        what: What,
    },
}

/// A model that flew before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Earlier {
    /// The one before
    Previous,
    /// The factory's
    Factory,
}

/// What is erased.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum What {
    /// All accepted models
    Models,
}

impl Request {
    /// The command that says it.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn command(&self) -> Result<Command, Failure> {
        Ok(match self {
            Self::SelfTest => Command::SelfTest,
            Self::Stream { every, bandwidth, max_age, exact } => Command::ConfigureStream(StreamConfig {
                bytes_per_s: *bandwidth,
                attitude_every: *every,
                attitude_format: if *exact { AttitudeFormat::Exact } else { AttitudeFormat::Compact },
                max_age_us: max_age.saturating_mul(1_000),
            }),
            Self::StartRecording { for_s } => Command::StartRecording { for_s: *for_s },
            Self::StopRecording => Command::StopRecording,
            Self::Survey { within } => Command::StationarySurvey { within_s: *within },
            Self::Configure { file } => Command::Configure(read(file)?),
            Self::ConfigureSurvey { file } => Command::ConfigureSurvey(read(file)?),
            Self::AcceptModel { window_end_us } => Command::AcceptModel { window_end_us: *window_end_us },
            Self::RollBack { to: Earlier::Previous } => Command::RollBackModel { to: EarlierModel::Previous },
            Self::RollBack { to: Earlier::Factory } => Command::RollBackModel { to: EarlierModel::Factory },
            Self::Erase { what: What::Models } => Command::Erase { what: Erasure::Models },
        })
    }
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| bad(format!("cannot be read: {e}")))?;
    toml::from_str(&text).map_err(|e| bad(e.to_string().trim_end().replace('\n', " ")))
}
