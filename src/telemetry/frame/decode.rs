//! Decoder of frames from a line that may be damaged anywhere.

use super::{CHECK, HEADER, Kind, crc::digest};
use cobs::{DecodeResult, DecoderState};

/// Frame whose CRC was right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// Number of its kind; see [`Kind::of_number`].
    pub kind: u8,
    /// Sequence number in the stream.
    pub sequence: u16,
    /// Payload.
    pub payload: &'a [u8],
}

/// Counters of a received line, which stop at their largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct LinkCounters {
    /// Frames whose CRC was right.
    pub frames: u32,
    /// Bytes between two zeros that are no frame: damaged, or noise.
    pub bad: u32,
    /// Frames longer than this receiver takes, damaged or not.
    pub oversize: u32,
    /// Sequence numbers that never came. 32,768 to 65,535 in a row count as a step back; multiples of 65,536 are not
    /// seen.
    pub lost: u32,
    /// Steps back in the sequence: a probe that started anew, or old frames.
    pub restarts: u32,
}

/// Finds frames in a stream of bytes that may be damaged anywhere. `N` is the longest frame it takes, without COBS:
/// payload and 7 bytes.
///
/// The decoder is in step again with the next zero byte, so that damage loses only the frames that it touches.
#[derive(Debug)]
pub struct FrameDecoder<const N: usize> {
    state: DecoderState,
    buffer: [u8; N],
    used: usize,
    oversize: bool,
    next: Option<u16>,
    counters: LinkCounters,
}

impl<const N: usize> FrameDecoder<N> {
    /// Returns a decoder that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: DecoderState::Idle,
            buffer: [0; N],
            used: 0,
            oversize: false,
            next: None,
            counters: LinkCounters { frames: 0, bad: 0, oversize: 0, lost: 0, restarts: 0 },
        }
    }

    /// Returns the counters.
    #[must_use]
    pub const fn counters(&self) -> LinkCounters {
        self.counters
    }

    /// Takes one byte; returns the frame that it ends.
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        let idle = matches!(self.state, DecoderState::Idle);
        match self.state.feed(byte) {
            // Zeros between frames are not counted as bad frames.
            Ok(DecodeResult::NoData) if idle && byte == 0 => None,
            Ok(DecodeResult::NoData) => {
                if idle {
                    self.used = 0;
                    self.oversize = false;
                }
                None
            }
            Ok(DecodeResult::DataContinue(decoded)) => {
                match self.buffer.get_mut(self.used) {
                    Some(place) => {
                        *place = decoded;
                        self.used += 1;
                    }
                    None => self.oversize = true,
                }
                None
            }
            Ok(DecodeResult::DataComplete) if !self.oversize => self.check(),
            Ok(DecodeResult::DataComplete) | Err(_) => {
                let counters = &mut self.counters;
                count(if self.oversize { &mut counters.oversize } else { &mut counters.bad }, 1);
                None
            }
        }
    }

    /// Checks the CRC and the sequence number of the bytes in the buffer.
    fn check(&mut self) -> Option<Frame<'_>> {
        let whole = self.buffer.get(..self.used).and_then(|bytes| {
            let (covered, check) = bytes.split_last_chunk::<CHECK>()?;
            let mut computed = digest();
            computed.update(covered);
            let right = computed.finalize() == u32::from_le_bytes(*check);
            let (header, payload) = covered.split_first_chunk::<HEADER>()?;
            right.then_some((header, payload))
        });
        let Some((&[kind, low, high], payload)) = whole else {
            count(&mut self.counters.bad, 1);
            return None;
        };
        let sequence = u16::from_le_bytes([low, high]);
        let missing = match self.next {
            // The first frame of a program is its boot, with number 0; other boots are frames like any other.
            Some(next) if kind != Kind::Boot.number() || sequence != 0 => sequence.wrapping_sub(next),
            _ => 0,
        };
        // A step ahead of 2^15 or more is more likely a step back.
        if missing < 1 << 15 {
            count(&mut self.counters.lost, missing.into());
        } else {
            count(&mut self.counters.restarts, 1);
        }
        count(&mut self.counters.frames, 1);
        self.next = Some(sequence.wrapping_add(1));
        Some(Frame { kind, sequence, payload })
    }
}

impl<const N: usize> Default for FrameDecoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Adds to a counter, which stops at its largest value.
const fn count(counter: &mut u32, more: u32) {
    *counter = counter.saturating_add(more);
}
