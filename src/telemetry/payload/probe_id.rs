//! Unique number of a probe.

use serde::{Deserialize, Serialize};

/// Unique number of a probe's chip. It is no secret: the probe states it in every [`Boot`](super::Boot) and
/// [`Health`](super::Health), and a command signed for one probe is refused by another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct ProbeId(pub [u8; 12]);

impl ProbeId {
    /// Makes the number from the three words of the chip's unique number.
    #[must_use]
    pub const fn of_words(words: [u32; 3]) -> Self {
        let [[a, b, c, d], [e, f, g, h], [i, j, k, l]] =
            [words[0].to_le_bytes(), words[1].to_le_bytes(), words[2].to_le_bytes()];
        Self([a, b, c, d, e, f, g, h, i, j, k, l])
    }

    /// Parses the 24 hexadecimal digits that `Display` writes.
    #[must_use]
    pub fn of_digits(digits: &str) -> Option<Self> {
        let mut id = [0; 12];
        let (pairs, []) = digits.as_bytes().as_chunks::<2>() else { return None };
        if pairs.len() != id.len() {
            return None;
        }
        for (byte, pair) in id.iter_mut().zip(pairs) {
            let [high, low] = pair.map(|digit| char::from(digit).to_digit(16));
            *byte = (high? << 4 | low?) as u8;
        }
        Some(Self(id))
    }
}

impl core::fmt::Display for ProbeId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

#[cfg(test)]
mod tests;
