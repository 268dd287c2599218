//! Why there is no flight on the emulated chip.

use std::io;

use meerkat_mwd::{config::ConfigError, sensor_models::PlayedCounts};

use super::{deadline::CommandError, image::ImageError, missing::Missing, wire::WireError};

/// Why there is no emulated flight.
#[derive(Debug, thiserror::Error)]
pub enum EmulateError {
    /// Something that is needed is not there.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// The configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The firmware does not build.
    #[error("the firmware cannot be built: {0}")]
    Build(CommandError),
    /// What was built is not an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file could not be read or written.
    #[error("{what}: {source}")]
    File {
        /// What was being done.
        what: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The trace has no encoding.
    #[error("the trace cannot be encoded: {0}")]
    Encode(#[from] postcard::Error),
    /// The emulator, or the firmware in it, failed.
    #[error("the emulated firmware failed: {0}")]
    Run(CommandError),
    /// The samples that came through the sensors there are not those that come through them here.
    #[error("the samples came through the sensors otherwise than on this machine: {there:?}, here {here:?}")]
    Sensors {
        /// What the firmware counted.
        there: Option<PlayedCounts>,
        /// What was counted here.
        here: PlayedCounts,
    },
    /// The firmware has no function of a part that is to be counted.
    #[error("no function of the firmware's belongs to the part {0:?}")]
    NoPart(&'static str),
    /// The counts of the parts are none.
    #[error("the emulator's plugin wrote no counts: {0:?}")]
    Counts(String),
    /// What the firmware wrote is not a flight.
    #[error("the emulated firmware wrote no whole flight: {0}")]
    Wire(#[from] WireError),
}
