//! One message on a line: COBS, so that a zero byte ends every frame and nothing else is one (Cheshire and Baker, IEEE/ACM Transactions on
//! Networking 7 (1999) 159), around
//!
//! | bytes | |
//! |---|---|
//! | 1 | [`Kind`] |
//! | 2 | sequence number of the direction, little-endian; it wraps |
//! | n | payload: postcard's encoding of what the kind says |
//! | 4 | CRC-32C of all bytes before it, little-endian |
//!
//! The payload is postcard's and not fixed-width by hand: one derive is encoder and decoder of the library's own reports, small numbers
//! and absent values take one byte, and f32 keep all their bits. Where a number uses its whole range it is fixed-width all the same.

mod crc;
mod decode;
mod encode;
mod kind;

pub use decode::{Frame, FrameDecoder, LinkCounters};
pub(super) use encode::encode_parts;
pub use encode::{EncodeError, encode_frame, encode_payload};
pub use kind::Kind;

/// Most bytes of a payload: a diagnosis takes up to 1,000.
pub const MAX_PAYLOAD: usize = 1_200;

/// Kind and sequence number.
const HEADER: usize = 3;

/// Length of the check.
const CHECK: usize = 4;

/// Most bytes of a frame on the line: COBS adds one to every 254, there is a zero behind them, and before the first frame.
pub const MAX_FRAME: usize = encoded_length(MAX_PAYLOAD) + 1;

/// Capacity of a [`FrameDecoder`] that takes every frame.
pub const MAX_DECODED: usize = HEADER + MAX_PAYLOAD + CHECK;

/// Most bytes on the line of a frame around a payload of so many.
pub(super) const fn encoded_length(payload: usize) -> usize {
    let inside = HEADER + payload + CHECK;
    inside + inside.div_ceil(254) + 1
}
