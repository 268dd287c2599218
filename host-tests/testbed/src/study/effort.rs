//! Effort of a measurement: its number of repetitions.

use std::ops::Range;

/// Number of repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A tenth, at least three: minutes become seconds.
    Quick,
    /// As many as the pages of measurements have.
    Full,
    /// This many.
    Seeds(u64),
    /// As many as these, with these as their seeds, for a measurement that tells of a seed by its number.
    These {
        /// The first.
        first: u64,
        /// Number of seeds.
        seeds: u64,
    },
}

impl Effort {
    /// The number of repetitions if `full` is that of the pages of measurements.
    #[must_use]
    pub fn repetitions(self, full: u64) -> u64 {
        match self {
            Self::Full => full,
            Self::Quick => (full / 10).max(3),
            Self::Seeds(seeds) | Self::These { seeds, .. } => seeds,
        }
    }

    /// The seeds if `full` is the number of those of the pages of measurements.
    #[must_use]
    pub fn seeds(self, full: u64) -> Range<u64> {
        let first = if let Self::These { first, .. } = self { first } else { 0 };
        first..first.saturating_add(self.repetitions(full))
    }
}
