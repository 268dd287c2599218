//! Authentication of commands: a keyed BLAKE2s code over the probe, the counter and the command. docs/security.md
//! says who can do what with it.

use super::Command;
use crate::{
    storage::{KEY_BYTES, can_be_key},
    telemetry::{EncodeError, ProbeId},
};
use blake2::{
    Blake2sMac,
    digest::{KeyInit, Mac, consts::U16},
};

/// Length of a counter, bytes.
const COUNTER: usize = 8;
/// Length of an authentication code, bytes: one forgery in 2^128 tries.
const TAG: usize = 16;

/// Key that a probe and the hosts that may calibrate it share. Best give each probe its own key; probes with the same
/// key take only commands that name them.
///
/// The key is never printed.
#[derive(Clone)]
pub struct Key {
    bytes: [u8; KEY_BYTES],
    probe: ProbeId,
}

impl Key {
    /// Makes a key for one probe. Returns `None` for bytes that were not drawn at random ([`can_be_key`]), such as
    /// memory that nobody has provisioned.
    #[must_use]
    pub fn new(bytes: &[u8; KEY_BYTES], probe: ProbeId) -> Option<Self> {
        can_be_key(bytes).then_some(Self { bytes: *bytes, probe })
    }

    /// BLAKE2s with a key (RFC 7693): 256-bit key and 128-bit code as HMAC-SHA-256 would have, without the second hash
    /// and 6 KiB of flash. Of algorithms that take less flash, SipHash with 128 bits is experimental to its own
    /// authors, and Poly1305 takes a new key for each message.
    fn code(&self, counter: [u8; COUNTER], command: &[u8]) -> Option<Blake2sMac<U16>> {
        let mut code = Blake2sMac::new_from_slice(&self.bytes).ok()?;
        code.update(PURPOSE);
        code.update(&self.probe.0);
        code.update(&counter);
        code.update(command);
        Some(code)
    }
}

/// Purpose string, hashed first: a code made for anything else with this key is not a command's.
const PURPOSE: &[u8; 24] = b"meerkat-mwd command v002";

impl core::fmt::Debug for Key {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Key")
    }
}

/// Writes the payload of a [`Kind::AuthenticatedCommand`](crate::telemetry::Kind) to the front of `buffer` and
/// returns it: counter (8 bytes, little-endian), code (16), command. The code is over the probe, the counter and the
/// command.
///
/// # Errors
/// The payload does not fit.
pub fn authenticate<'a>(
    key: &Key,
    counter: u64,
    command: &Command,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    let too_short = EncodeError::PayloadTooLong { bytes: None };
    let counter = counter.to_le_bytes();
    let (head, body) = buffer.split_at_mut_checked(COUNTER + TAG).ok_or(too_short)?;
    let length = postcard::to_slice(command, body).map_err(|_| too_short)?.len();
    let code = key.code(counter, body.get(..length).ok_or(too_short)?).ok_or(too_short)?.finalize().into_bytes();
    for (place, byte) in head.iter_mut().zip(counter.into_iter().chain(code)) {
        *place = byte;
    }
    buffer.get(..COUNTER + TAG + length).ok_or(too_short)
}

/// Parts of an authenticated command, not yet verified.
pub(super) struct Authenticated<'a> {
    counter: [u8; COUNTER],
    tag: &'a [u8; TAG],
    command: &'a [u8],
}

impl<'a> Authenticated<'a> {
    pub fn split(payload: &'a [u8]) -> Option<Self> {
        let (counter, rest) = payload.split_first_chunk()?;
        let (tag, command) = rest.split_first_chunk()?;
        Some(Self { counter: *counter, tag, command })
    }

    /// Returns counter and command if the code is right. The comparison takes the same time wherever they differ.
    pub fn verify(&self, key: &Key) -> Option<(u64, &'a [u8])> {
        key.code(self.counter, self.command)?.verify_slice(self.tag).ok()?;
        Some((u64::from_le_bytes(self.counter), self.command))
    }
}
