//! One message on a line: COBS, so that a zero byte ends every frame and nothing else is one (Cheshire and Baker,
//! IEEE/ACM Transactions on Networking 7 (1999) 159), around
//!
//! | bytes | |
//! |---|---|
//! | 1 | [`Kind`] |
//! | 2 | sequence number in this direction of the line, little-endian; it wraps |
//! | n | payload: postcard's encoding of the type that belongs to the kind |
//! | 4 | CRC-32C of all bytes before it, little-endian |
//!
//! The payload is postcard's and not fixed-width by hand: one derive is encoder and decoder of the library's own
//! reports, small numbers and absent values take one byte, and f32 keep all their bits. Numbers that use their whole
//! range are still fixed-width.

mod crc;
mod decode;
mod encode;
mod kind;

pub use decode::{Frame, FrameDecoder, LinkCounters};
pub(super) use encode::encode_parts;
pub use encode::{EncodeError, encode_frame, encode_payload};
pub use kind::Kind;

/// Largest payload, bytes: a diagnosis takes up to 1,000.
pub const MAX_PAYLOAD: usize = 1_200;

/// Kind and sequence number.
const HEADER: usize = 3;

/// Length of the check.
const CHECK: usize = 4;

/// Longest frame on the line, bytes: COBS adds one byte to every 254, a zero byte ends the frame, and another one
/// precedes the first frame.
pub const MAX_FRAME: usize = encoded_length(MAX_PAYLOAD) + 1;

/// Capacity of a [`FrameDecoder`] that takes every frame.
pub const MAX_DECODED: usize = HEADER + MAX_PAYLOAD + CHECK;

/// Returns the length of the longest frame on the line around a payload of this many bytes.
pub(super) const fn encoded_length(payload: usize) -> usize {
    let inside = HEADER + payload + CHECK;
    inside + inside.div_ceil(254) + 1
}
