//! Effort of a measurement: its number of repetitions.

/// Number of repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A tenth, at least three: minutes become seconds.
    Quick,
    /// As many as the pages of measurements have.
    Full,
    /// This many.
    Seeds(u64),
}

impl Effort {
    /// The number of repetitions if `full` is that of the pages of measurements.
    #[must_use]
    pub fn repetitions(self, full: u64) -> u64 {
        match self {
            Self::Full => full,
            Self::Quick => (full / 10).max(3),
            Self::Seeds(seeds) => seeds,
        }
    }
}
