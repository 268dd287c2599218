//! Commands encoded as bytes for the line.

use meerkat_mwd::telemetry::{Command, Kind, MAX_FRAME, MAX_PAYLOAD, encode_frame, encode_payload};

/// The frame of a command that needs no authentication.
///
/// # Errors
/// Never in practice: every command fits.
pub fn frame_of(command: &Command, sequence: u16) -> anyhow::Result<Vec<u8>> {
    let mut payload = [0; MAX_PAYLOAD];
    framed(Kind::Command, sequence, encode_payload(command, &mut payload)?)
}

/// A frame with this payload, after a zero byte.
///
/// # Errors
/// The payload is too long for a frame.
pub fn framed(kind: Kind, sequence: u16, payload: &[u8]) -> anyhow::Result<Vec<u8>> {
    let mut buffer = [0; MAX_FRAME];
    // A zero ends whatever noise the probe has heard before.
    let mut bytes = vec![0];
    bytes.extend_from_slice(encode_frame(kind, sequence, payload, &mut buffer)?);
    Ok(bytes)
}
