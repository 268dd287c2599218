//! Reasons why there is no flight on the emulated chip.

use std::io;

use meerkat_mwd::{config::ConfigError, emulation::PlayedCounts};

use super::{deadline::CommandError, image::ImageError, missing::Missing, wire::WireError};

/// Reasons why there is no emulated flight.
#[derive(Debug, thiserror::Error)]
pub enum EmulateError {
    /// A tool is missing.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// The configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The firmware does not build.
    #[error("the firmware cannot be built: {0}")]
    Build(CommandError),
    /// The file that was built is not an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file could not be read or written.
    #[error("{what}: {source}")]
    File {
        /// Action that was tried.
        what: &'static str,
        /// Error of the system.
        source: io::Error,
    },
    /// The trace has no encoding.
    #[error("the trace cannot be encoded: {0}")]
    Encode(#[from] postcard::Error),
    /// The emulator, or the firmware in it, failed.
    #[error("the emulated firmware failed: {0}")]
    Run(CommandError),
    /// The samples that came through the sensor models differ between chip and host.
    #[error("the samples came through the sensors otherwise than on this machine: {there:?}, here {here:?}")]
    Sensors {
        /// Counts of the firmware.
        there: Option<PlayedCounts>,
        /// Counts of this machine.
        here: PlayedCounts,
    },
    /// The firmware has no function of a call to be counted.
    #[error("the firmware has no function whose mangled name holds {0}")]
    NoCall(String),
    /// The plugin's output is not counts.
    #[error("the emulator's plugin wrote no counts: {0:?}")]
    Counts(String),
    /// The firmware's output is not a whole flight.
    #[error("the emulated firmware wrote no whole flight: {0}")]
    Wire(#[from] WireError),
}
