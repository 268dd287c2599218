//! Encoder of frames.

use super::{CHECK, HEADER, Kind, MAX_PAYLOAD, crc::digest, encoded_length};
use crate::telemetry::Payload;
use cobs::{CobsEncoder, DestBufTooSmallError};
use crc::{Digest, NoTable};

/// Reason for which no frame was encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// The payload is longer than [`MAX_PAYLOAD`].
    PayloadTooLong {
        /// Length of the payload, bytes; `None` if it did not even fit into the buffer for payloads.
        bytes: Option<usize>,
    },
    /// The caller's buffer is too short.
    BufferTooShort {
        /// Length that is enough, bytes.
        needed: usize,
    },
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::PayloadTooLong { bytes: Some(bytes) } => write!(f, "a payload of {bytes} bytes, {MAX_PAYLOAD} fit"),
            Self::PayloadTooLong { bytes: None } => write!(f, "a payload of more than {MAX_PAYLOAD} bytes"),
            Self::BufferTooShort { needed } => write!(f, "the frame needs a buffer of {needed} bytes"),
        }
    }
}

impl core::error::Error for EncodeError {}

/// Writes the payload's bytes to the front of `buffer` and returns them.
///
/// # Errors
/// The payload does not fit.
pub fn encode_payload<'a>(payload: &impl Payload, buffer: &'a mut [u8]) -> Result<&'a [u8], EncodeError> {
    postcard::to_slice(payload, buffer).map(|bytes| &*bytes).map_err(|_| EncodeError::PayloadTooLong { bytes: None })
}

/// Writes a whole frame, with the zero that ends it, to the front of `buffer` and returns it.
/// [`MAX_FRAME`](super::MAX_FRAME) bytes are enough for any.
///
/// # Errors
/// The payload is too long for any receiver, or the buffer too short.
pub fn encode_frame<'a>(
    kind: Kind,
    sequence: u16,
    payload: &[u8],
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    encode_parts(kind.number(), sequence, [payload, &[]], buffer)
}

/// Encodes a payload in two pieces, as a ring buffer holds it.
pub(in crate::telemetry) fn encode_parts<'a>(
    kind: u8,
    sequence: u16,
    [front, back]: [&[u8]; 2],
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    let length = front.len() + back.len();
    if length > MAX_PAYLOAD {
        return Err(EncodeError::PayloadTooLong { bytes: Some(length) });
    }
    let used = stuff(kind, sequence, [front, back], buffer);
    let too_short = EncodeError::BufferTooShort { needed: encoded_length(length) };
    let end = used.map_err(|DestBufTooSmallError| too_short)?;
    *buffer.get_mut(end).ok_or(too_short)? = 0;
    buffer.get(..=end).ok_or(too_short)
}

fn stuff(kind: u8, sequence: u16, parts: [&[u8]; 2], buffer: &mut [u8]) -> Result<usize, DestBufTooSmallError> {
    let [low, high] = sequence.to_le_bytes();
    let header: [u8; HEADER] = [kind, low, high];
    let mut stuffing = Stuffing { check: digest(), encoder: CobsEncoder::new(buffer) };
    stuffing.put(&header)?;
    stuffing.put(parts[0])?;
    stuffing.put(parts[1])?;
    let check: [u8; CHECK] = stuffing.check.clone().finalize().to_le_bytes();
    stuffing.put(&check)?;
    Ok(stuffing.encoder.finalize())
}

struct Stuffing<'a> {
    check: Digest<'static, u32, NoTable>,
    encoder: CobsEncoder<'a>,
}

impl Stuffing<'_> {
    // CRC and COBS both loop over the bytes; inlined, these loops would be in flash four times.
    #[inline(never)]
    fn put(&mut self, bytes: &[u8]) -> Result<(), DestBufTooSmallError> {
        self.check.update(bytes);
        self.encoder.push(bytes)
    }
}
