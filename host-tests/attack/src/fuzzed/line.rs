//! Bytes of a serial line: frames, and the payloads in them.

use meerkat_mwd::telemetry::{Frame, FrameDecoder, Kind, MAX_DECODED, MAX_FRAME, MAX_PAYLOAD, Message, encode_frame};

/// Bytes of a line. A frame that is found in them is found again where it is encoded anew.
///
/// # Panics
/// It is not.
pub fn frame(bytes: &[u8]) {
    let mut decoder = FrameDecoder::<MAX_DECODED>::new();
    let (mut found, mut ends) = (0, 0);
    for byte in bytes {
        ends += u32::from(*byte == 0);
        let Some(frame) = decoder.push(*byte) else { continue };
        found += 1;
        let Some(kind) = Kind::of_number(frame.kind) else { continue };
        if frame.payload.len() > MAX_PAYLOAD {
            continue;
        }
        let mut buffer = [0; MAX_FRAME];
        let encoded = encode_frame(kind, frame.sequence, frame.payload, &mut buffer);
        let mut again = FrameDecoder::<MAX_DECODED>::new();
        let same = encoded.is_ok_and(|encoded| encoded.iter().any(|byte| again.push(*byte) == Some(frame)));
        assert!(same, "{frame:?}");
    }
    let counters = decoder.counters();
    assert_eq!(counters.frames, found);
    assert!(found + counters.bad + counters.oversize <= ends, "every frame ends with a zero");
}

/// A kind and a payload.
pub fn message(bytes: &[u8]) {
    let Some((kind, payload)) = bytes.split_first() else { return };
    if let Ok(message) = Message::decode(&Frame { kind: *kind, sequence: 0, payload }) {
        let _ = format!("{message:?}");
    }
}
