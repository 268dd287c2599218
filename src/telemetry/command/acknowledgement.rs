//! Answer to a command: carried out, or refused with the reason. Every frame that is a command gets one, unless its
//! sender asks too often (`Judgement::Ignore`).

use crate::telemetry::{Kind, Payload};
use serde::{Deserialize, Serialize};

/// Answer to one command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct Acknowledgement {
    /// Sequence number of the command's frame.
    pub sequence: u16,
    /// Outcome of the command.
    pub outcome: Outcome,
}

/// Outcome of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum Outcome {
    /// The command is carried out.
    Accepted,
    /// The command is refused; nothing was done.
    Refused(CommandRefusal),
}

/// Name of a configuration's field, cut off where it is longer.
pub type FieldName = heapless::String<48>;

/// Reason for which nothing was done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum CommandRefusal {
    /// The frame is no command of this version.
    Malformed,
    /// A number in the command is out of its bounds.
    OutOfBounds {
        /// Name of the field.
        field: FieldName,
    },
    /// The command needs the key and came without authentication.
    NotAuthenticated,
    /// No key is provisioned: commands that need one are refused.
    NoKey,
    /// The authentication code is not that of this key, counter and command.
    Forged,
    /// The counter was used before.
    Replayed {
        /// Latest counter that was used.
        latest: u64,
    },
    /// The counter is too far ahead of the latest.
    CounterTooFar {
        /// Latest counter that was used.
        latest: u64,
    },
    /// The counter could not be read or stored: without it authenticated commands are refused. At rest the probe then
    /// makes room, and the next try passes.
    CounterNotStored,
    /// The tool is drilling.
    WhileDrilling,
    /// The model or window that the command names is not there, or not any more.
    NothingThere,
    /// An earlier command is not finished, a program is on trial, or, without the key, reports were asked for too
    /// often.
    Busy,
    /// The storage failed.
    StorageFailed,
    /// This probe does not support the command.
    NotSupported,
    /// The model is beyond the limits that every model has to keep before it may fly.
    ModelImplausible,
    /// The factory has written another such record, or has closed the probe with the key.
    AlreadyProvisioned,
    /// The image's number is not above those of the images that are there.
    ImageNotNewer {
        /// Highest number that is there.
        stored: u32,
    },
    /// The image is empty or does not fit.
    ImageSize,
    /// The bytes are not the image's next ones.
    NotTheNext {
        /// Offset of the next bytes.
        expected: u32,
    },
    /// The image received is not the one that was announced.
    NotTheImage,
}

impl core::fmt::Display for CommandRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Malformed => f.write_str("no command of this version"),
            Self::OutOfBounds { field } => write!(f, "{field} is out of its bounds"),
            Self::NotAuthenticated => f.write_str("it needs the key and came without authentication"),
            Self::NoKey => f.write_str("no key is provisioned"),
            Self::Forged => f.write_str("the authentication code is wrong: another key?"),
            Self::Replayed { latest } => write!(f, "the counter was used before; the latest is {latest}"),
            Self::CounterTooFar { latest } => write!(f, "the counter is too far ahead of the latest, {latest}"),
            Self::CounterNotStored => f.write_str("the counter could not be stored"),
            Self::WhileDrilling => f.write_str("the tool is drilling"),
            Self::NothingThere => f.write_str("the model or window that is meant is not there"),
            Self::Busy => f.write_str("what an earlier command started is not done"),
            Self::StorageFailed => f.write_str("the memory refused"),
            Self::NotSupported => f.write_str("this probe cannot"),
            Self::ModelImplausible => f.write_str("the model is beyond the limits of any that may fly"),
            Self::AlreadyProvisioned => f.write_str("the factory's record is another, or the probe is closed"),
            Self::ImageNotNewer { stored } => write!(f, "it has an image of number {stored}; a new one must be above"),
            Self::ImageSize => f.write_str("the image is empty or does not fit"),
            Self::NotTheNext { expected } => write!(f, "the image's next bytes are those from {expected} on"),
            Self::NotTheImage => f.write_str("what it received is not the image that was announced"),
        }
    }
}

impl Payload for Acknowledgement {
    const KIND: Kind = Kind::Acknowledgement;
}
