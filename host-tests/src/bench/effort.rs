//! How much a measurement may take.

/// How many repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A look: minutes become seconds.
    Quick,
    /// What the README states.
    Full,
    /// As many as were asked for.
    Seeds(u64),
}

impl Effort {
    /// `full` repetitions, or a tenth of them, at least three, or as many as were asked for.
    #[must_use]
    pub fn repetitions(self, full: u64) -> u64 {
        match self {
            Self::Full => full,
            Self::Quick => (full / 10).max(3),
            Self::Seeds(seeds) => seeds,
        }
    }
}
