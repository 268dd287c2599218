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
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn what_is_displayed_is_read() {
        let id = ProbeId::of_words([0x0403_0201, 0x0807_0605, 0xfc0b_0a09]);
        assert_eq!(id.to_string(), "0102030405060708090a0bfc");
        assert_eq!(ProbeId::of_digits(&id.to_string()), Some(id));
        for bad in ["", "01", "0102030405060708090a0bf", "0102030405060708090a0bfg", "0102030405060708090a0b0c0d"] {
            assert_eq!(ProbeId::of_digits(bad), None, "{bad}");
        }
    }
}
