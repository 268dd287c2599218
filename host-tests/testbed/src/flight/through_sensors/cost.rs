//! Cost of the sampling path, as the emulated firmware prints it.

use meerkat_mwd::emulation::PlayedCounts;

/// Instructions of the sampling path per sample, and what the chip counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingCost {
    /// Instructions of adapters, supervision and combiner.
    pub adapters: f64,
    /// Instructions of wires and register models; a board has hardware for these.
    pub wires: f64,
    /// Largest sum of both for one sample.
    pub most: f64,
    /// Samples that came through, as the chip counted them.
    pub counts: PlayedCounts,
}

impl SamplingCost {
    /// Reads what the firmware prints of a flight through the adapters: a line that begins with `sampling`,
    /// then names and numbers.
    #[must_use]
    pub fn said(text: &str) -> Option<Self> {
        let line = text.lines().find_map(|line| line.strip_prefix("sampling "))?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |name: &str| -> Option<u64> {
            let place = words.iter().position(|word| *word == name)?;
            words.get(place + 1)?.parse().ok()
        };
        let truths = number("truths")? as f64;
        let (instructions, wires) = (number("instructions")?, number("wires")?);
        Some(Self {
            adapters: instructions.checked_sub(wires)? as f64 / truths,
            wires: wires as f64 / truths,
            most: number("most")? as f64,
            counts: PlayedCounts {
                samples: u32::try_from(number("samples")?).ok()?,
                lost: u32::try_from(number("lost")?).ok()?,
                stamp_error_us: number("stamp_error_us")?,
            },
        })
    }
}
