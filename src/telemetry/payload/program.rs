//! The program that runs, and the parts in which another one comes.

use super::Payload;
use crate::telemetry::Kind;
use serde::{Deserialize, Serialize};

/// The program that runs, of the two that a probe has room for. It is sent with the health.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramReport {
    /// Number of the image that runs.
    pub number: u32,
    /// True if it has confirmed that it runs well. If not, the next start takes the other image, where that one was
    /// confirmed.
    pub confirmed: bool,
    /// Number of the other whole image; `None` if there is none, or one is being received.
    pub other: Option<u32>,
    /// Bytes received of the image that is being received; `None` if none is.
    pub received: Option<u32>,
}

impl Payload for ProgramReport {
    const KIND: Kind = Kind::Program;
}

/// Successive bytes of an image that a command has announced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImagePart<'a> {
    /// Offset of the first byte in the image.
    pub offset: u32,
    /// The bytes: [`ImagePart::BYTES`] of them, fewer in the last part.
    pub bytes: &'a [u8],
}

impl ImagePart<'_> {
    /// Bytes of every part but the last.
    pub const BYTES: usize = 512;
}

impl Payload for ImagePart<'_> {
    const KIND: Kind = Kind::ImagePart;
}
