//! Frames and messages in bytes of a line.

use meerkat_mwd::telemetry::{FrameDecoder, MAX_DECODED, Message};

pub type Decoder = FrameDecoder<MAX_DECODED>;

/// Every frame in the bytes: kind, sequence, payload.
pub fn frames(decoder: &mut Decoder, bytes: &[u8]) -> Vec<(u8, u16, Vec<u8>)> {
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(frame) = decoder.push(byte) {
            found.push((frame.kind, frame.sequence, frame.payload.to_vec()));
        }
    }
    found
}

/// Every message in the bytes.
pub fn messages(bytes: &[u8]) -> Vec<Message> {
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for &byte in bytes {
        if let Some(frame) = decoder.push(byte) {
            found.push(Message::decode(&frame).unwrap());
        }
    }
    let counters = decoder.counters();
    assert_eq!((counters.bad, counters.lost, counters.oversize, counters.restarts), (0, 0, 0, 0));
    found
}
