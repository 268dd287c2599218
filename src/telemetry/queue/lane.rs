//! Lane: queue of one class of payloads, as a ring of bytes.

use super::{super::MAX_PAYLOAD, MAX_FRAME, Payload, counters::count, encode_parts};
use heapless::deque::{Deque, DequeView};
use postcard::ser_flavors::Flavor;

/// Header before each payload: its length, its kind, and the low 32 bits of the time at which it was pushed,
/// microseconds.
const ENTRY_HEADER: usize = 7;

/// Reason for which a lane did not take a payload.
pub(super) enum Refused {
    NoRoom,
    TooLong,
}

/// Payloads in the order in which they came, in a ring of `N` bytes.
pub(super) struct Lane<const N: usize> {
    ring: Deque<u8, N>,
}

impl<const N: usize> Lane<N> {
    pub const fn new() -> Self {
        Self { ring: Deque::new() }
    }

    pub fn is_empty(&self) -> bool {
        self.ring.is_empty()
    }

    /// Returns the free bytes.
    pub fn room(&self) -> usize {
        N.saturating_sub(self.ring.len())
    }

    /// Takes a payload if there is room.
    pub fn write<P: Payload>(&mut self, now_us: u64, payload: &P) -> Result<(), Refused> {
        write(self.ring.as_mut_view(), now_us, payload)
    }

    /// Takes a payload and drops the oldest ones to make room. Counts each dropped payload, also this one if it does
    /// not fit even alone.
    pub fn write_over<P: Payload>(&mut self, now_us: u64, payload: &P, forgotten: &mut u32) {
        while let Err(refused) = self.write(now_us, payload) {
            count(forgotten);
            if matches!(refused, Refused::TooLong) {
                return;
            }
            self.forget_oldest();
        }
    }

    pub fn forget_oldest(&mut self) {
        forget_oldest(self.ring.as_mut_view());
    }

    /// Returns true if the oldest payload has waited for longer than `age_us`.
    pub fn oldest_is_over(&self, now_us: u64, age_us: u32) -> bool {
        entry(self.ring.as_view()).is_some_and(|entry| (now_us as u32).wrapping_sub(entry.pushed_us) > age_us)
    }

    /// Makes a frame of the oldest payload and drops the payload.
    pub fn take<'a>(&mut self, sequence: u16, buffer: &'a mut [u8; MAX_FRAME]) -> Option<&'a [u8]> {
        take(self.ring.as_mut_view(), sequence, buffer)
    }
}

struct Entry {
    length: usize,
    kind: u8,
    pushed_us: u32,
}

fn entry(ring: &DequeView<u8>) -> Option<Entry> {
    let mut bytes = ring.iter().copied();
    let mut next = || bytes.next();
    let length = u16::from_le_bytes([next()?, next()?]);
    let kind = next()?;
    let pushed_us = u32::from_le_bytes([next()?, next()?, next()?, next()?]);
    Some(Entry { length: length.into(), kind, pushed_us })
}

#[inline(never)]
fn write<P: Payload>(ring: &mut DequeView<u8>, now_us: u64, payload: &P) -> Result<(), Refused> {
    let start = ring.storage_len();
    let written = postcard::serialize_with_flavor(payload, Tail::new(ring)).unwrap_or(false);
    finish(ring, start, written, P::KIND.number(), now_us as u32)
}

/// Fills in the header at `start`, before the payload that was just written; removes both if the payload did not fit.
#[inline(never)]
fn finish(ring: &mut DequeView<u8>, start: usize, written: bool, kind: u8, pushed_us: u32) -> Result<(), Refused> {
    let length = ring.storage_len().saturating_sub(start + ENTRY_HEADER);
    if !written || length > MAX_PAYLOAD {
        ring.truncate(start);
        return Err(if written || start == 0 { Refused::TooLong } else { Refused::NoRoom });
    }
    let [a, b] = (length as u16).to_le_bytes();
    let [c, d, e, f] = pushed_us.to_le_bytes();
    for (offset, byte) in [a, b, kind, c, d, e, f].into_iter().enumerate() {
        if let Some(place) = ring.get_mut(start + offset) {
            *place = byte;
        }
    }
    Ok(())
}

fn forget_oldest(ring: &mut DequeView<u8>) {
    let length = entry(ring).map_or(ring.storage_len(), |entry| ENTRY_HEADER + entry.length);
    for _ in 0..length {
        ring.pop_front();
    }
}

fn take<'a>(ring: &mut DequeView<u8>, sequence: u16, buffer: &'a mut [u8; MAX_FRAME]) -> Option<&'a [u8]> {
    let Entry { length, kind, .. } = entry(ring)?;
    let (front, back) = ring.as_slices();
    // Payload bytes (`length`, behind the header) in each of the ring's two pieces.
    let end = ENTRY_HEADER + length;
    let (in_front, behind) = (front.len().min(end), end.saturating_sub(front.len()));
    let parts =
        [front.get(ENTRY_HEADER.min(in_front)..in_front)?, back.get(ENTRY_HEADER.saturating_sub(front.len())..behind)?];
    // A zero before the first frame separates it from bytes that were on the line before the probe started.
    let silence = usize::from(sequence == 0);
    *buffer.first_mut()? = 0;
    let encoded = encode_parts(kind, sequence, parts, buffer.get_mut(silence..)?).ok().map(<[u8]>::len);
    forget_oldest(ring);
    buffer.get(..silence + encoded?)
}

/// Writes a payload behind what is in the ring, with room for its header before it.
///
/// The writer accepts every byte and remembers if room ran out, so that no error is checked after each number of a
/// report. That, and one call for each number instead of an unrolled loop, halve the flash that all reports' encodings
/// would take.
struct Tail<'a> {
    ring: &'a mut DequeView<u8>,
    over: bool,
}

impl<'a> Tail<'a> {
    fn new(ring: &'a mut DequeView<u8>) -> Self {
        let mut tail = Self { ring, over: false };
        tail.put(&[0; ENTRY_HEADER]);
        tail
    }

    #[inline(never)]
    fn put(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.over |= self.ring.push_back(byte).is_err();
        }
    }
}

impl Flavor for Tail<'_> {
    /// True if there was room for all bytes.
    type Output = bool;

    #[inline]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.put(&[byte]);
        Ok(())
    }

    #[inline]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.put(bytes);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<bool> {
        Ok(!self.over)
    }
}

#[cfg(test)]
mod tests;
