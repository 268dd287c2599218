//! FIFO of ST's inertial modules.

use super::{Burst, Frame};

/// Bytes of one word in the FIFO of ST's inertial modules: a tag, and three axes of two bytes, low byte
/// first.
pub(super) const WORD: usize = 7;
/// Bytes of a line that nobody drives.
const IDLE: u8 = 0xFF;
/// Words of a frame: one of the gyro and one of the accelerometer.
const WORDS_OF_A_FRAME: u16 = 2;

/// Bursts between readings of the thermometer, which updates 52 (ISM330DHCX) or 60 (LSM6DSV320X) times a second.
const BURSTS_PER_TEMPERATURE: u8 = 16;

/// FIFO of ST's inertial modules, with gyro and accelerometer batched at one rate: pairs words into frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct StFifo {
    gyro_tag: u8,
    accel_tag: u8,
    /// True if bit 0 of a tag makes its parity even.
    has_parity: bool,
    /// Frame of whose two words only the first has been read.
    open: Option<Open>,
    /// Last code of the thermometer, read in one of [`BURSTS_PER_TEMPERATURE`] bursts.
    temperature: Option<i32>,
    /// Bursts since the thermometer was read, modulo [`BURSTS_PER_TEMPERATURE`].
    bursts: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Open {
    frame: Frame<2>,
    /// Time slot, 0 to 3, in the tag of the frame's first word; `None` if that word was corrupt.
    slot: Option<u8>,
}

impl StFifo {
    pub const fn new(gyro_tag: u8, accel_tag: u8, has_parity: bool) -> Self {
        Self { gyro_tag, accel_tag, has_parity, open: None, temperature: None, bursts: 0 }
    }

    /// Clears the state after a new start of the part.
    pub fn clear(&mut self) {
        *self = Self::new(self.gyro_tag, self.accel_tag, self.has_parity);
    }

    /// Returns true if the thermometer must be read with the next burst.
    pub const fn temperature_is_due(&self) -> bool {
        self.bursts == 0
    }

    /// Takes a code of the thermometer.
    pub const fn set_temperature(&mut self, code: i32) {
        self.temperature = Some(code);
    }

    /// Counts a burst.
    pub const fn count_burst(&mut self) {
        self.bursts = (self.bursts + 1) % BURSTS_PER_TEMPERATURE;
    }

    /// Drops the open frame after words may have been lost.
    pub fn interrupted(&mut self) {
        self.open = None;
    }

    /// Pairs the words in `bytes` into frames; `left` words are still in the part.
    pub fn take(&mut self, bytes: &[u8], mut left: u16, burst: &mut Burst<2>) {
        let mut words = bytes.as_chunks::<WORD>().0.iter().peekable();
        while let Some(word) = words.next() {
            if word == &[0; WORD] {
                // A word of zeros: the FIFO held fewer words than its level said.
                burst.corrupt = burst.corrupt.saturating_add(1);
                left = 0;
                break;
            }
            // A line that idles through the next word may have begun to within this one.
            let may_be_cut = word.ends_with(&[IDLE]) && words.peek() == Some(&&[IDLE; WORD]);
            self.word(word, may_be_cut, burst);
        }
        let open = u16::from(self.open.is_some());
        burst.left = (left + open) / WORDS_OF_A_FRAME;
    }

    fn word(&mut self, &[tag, x0, x1, y0, y1, z0, z1]: &[u8; WORD], may_be_cut: bool, burst: &mut Burst<2>) {
        let codes = [[x0, x1], [y0, y1], [z0, z1]].map(|bytes| i32::from(i16::from_le_bytes(bytes)));
        let sensor = tag >> 3;
        let sound = !may_be_cut && (!self.has_parity || tag.count_ones().is_multiple_of(2));
        let slot = (sound && (sensor == self.gyro_tag || sensor == self.accel_tag)).then_some(tag >> 1 & 3);
        if slot.is_none() {
            burst.corrupt = burst.corrupt.saturating_add(1);
        }
        // Words of different slots do not belong together: a word was lost between them.
        let fits = |open: &Open| open.slot.is_none() || slot.is_none() || open.slot == slot;
        let first = match self.open.take() {
            Some(open) if fits(&open) => Some(open.frame),
            Some(open) => {
                burst.push(open.frame);
                None
            }
            None => None,
        };
        let mut frame = first.unwrap_or(Frame { temperature: self.temperature, ..Frame::default() });
        let [gyro, accel] = &mut frame.codes;
        if slot.is_some() {
            *(if sensor == self.gyro_tag { gyro } else { accel }) = Some(codes);
        }
        if first.is_some() {
            burst.push(frame);
        } else {
            self.open = Some(Open { frame, slot });
        }
    }
}

#[cfg(test)]
mod tests;
