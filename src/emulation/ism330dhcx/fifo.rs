//! The FIFO: words of a tag and six bytes (data sheet DS13012, chapter on the FIFO; application note AN5398, chapter
//! "First-in first-out (FIFO) buffer").

/// Words in the FIFO of an ISM330DHCX: 3 Kbyte of six data bytes each (DS13012, chapter on the FIFO).
pub const DEPTH: usize = 512;

/// Content of a word (DS13012, FIFO_DATA_OUT_TAG, table of the tags).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tag {
    /// Angular rate.
    Gyro = 0x01,
    /// Specific force.
    Accelerometer = 0x02,
    /// Temperature.
    Temperature = 0x03,
    /// The part's own time.
    Timestamp = 0x04,
}

/// Tag byte and data.
type Word = [u8; 7];

/// Tag, count of the time slot in two bits, and the bit that makes the byte's parity even (DS13012, FIFO_DATA_OUT_TAG).
pub fn tag_byte(tag: Tag, slot: u8) -> u8 {
    let byte = (tag as u8) << 3 | (slot & 3) << 1;
    byte | (byte.count_ones() & 1) as u8
}

/// A ring of words.
#[derive(Clone, Debug)]
pub(super) struct Fifo<const WORDS: usize> {
    words: [Word; WORDS],
    first: usize,
    length: usize,
    slot: u8,
    pub(super) overrun: bool,
    pub(super) overrun_latched: bool,
}

impl<const WORDS: usize> Fifo<WORDS> {
    pub(super) const fn empty() -> Self {
        Self { words: [[0; 7]; WORDS], first: 0, length: 0, slot: 0, overrun: false, overrun_latched: false }
    }

    pub(super) fn clear(&mut self) {
        (self.first, self.length, self.overrun, self.overrun_latched) = (0, 0, false, false);
    }

    pub(super) const fn length(&self) -> usize {
        self.length
    }

    pub(super) const fn is_full(&self) -> bool {
        self.length >= WORDS
    }

    /// Begins a time slot: the words pushed next belong to it.
    pub(super) fn next_slot(&mut self) {
        self.slot = self.slot.wrapping_add(1) & 3;
    }

    /// Appends a word. Without room the oldest word is dropped, or with `stops` the new one.
    pub(super) fn push(&mut self, tag: Tag, data: [u8; 6], room: usize, stops: bool) {
        let room = room.min(WORDS);
        if self.length >= room {
            self.overrun = true;
            self.overrun_latched = true;
            if stops || room == 0 {
                return;
            }
            self.drop_oldest(self.length + 1 - room);
        }
        let [a, b, c, d, e, f] = data;
        let place = (self.first + self.length).checked_rem(WORDS).unwrap_or(0);
        if let Some(word) = self.words.get_mut(place) {
            *word = [tag_byte(tag, self.slot), a, b, c, d, e, f];
            self.length += 1;
        }
    }

    /// Drops up to `count` of the oldest words.
    pub(super) fn drop_oldest(&mut self, count: usize) {
        let count = count.min(self.length);
        self.first = (self.first + count).checked_rem(WORDS).unwrap_or(0);
        self.length -= count;
    }

    /// Reads the byte at one of the seven output addresses; an empty FIFO reads 0. Reading the last byte drops the
    /// word.
    pub(super) fn read(&mut self, byte: usize) -> u8 {
        if self.length == 0 {
            return 0;
        }
        let value = self.words.get(self.first).and_then(|word| word.get(byte)).copied().unwrap_or(0);
        if byte == 6 {
            self.drop_oldest(1);
            self.overrun = false;
        }
        value
    }
}

#[cfg(test)]
mod tests;
