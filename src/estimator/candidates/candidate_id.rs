//! Candidates by number: the library's effects, then the further steps of the bias, then the errors of the vector
//! sensors that the library has no name for.

/// One competitor for the evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CandidateId(u8);

impl CandidateId {
    /// Candidate by its number; that of an effect is its index in the library.
    #[must_use]
    pub const fn new(number: usize) -> Self {
        Self(number as u8)
    }

    /// Number of the candidate.
    #[must_use]
    pub const fn number(self) -> usize {
        self.0 as usize
    }
}

/// Set of candidates, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CandidateSet(u32);

impl CandidateSet {
    /// The set without members.
    pub const EMPTY: Self = Self(0);

    /// The members as bits, that of candidate 0 the lowest.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.0
    }

    const fn bit(candidate: CandidateId) -> u32 {
        match 1_u32.checked_shl(candidate.0 as u32) {
            Some(bit) => bit,
            None => 0,
        }
    }

    pub(crate) const fn has(self, candidate: CandidateId) -> bool {
        self.0 & Self::bit(candidate) != 0
    }

    pub(super) const fn insert(&mut self, candidate: CandidateId) {
        self.0 |= Self::bit(candidate);
    }

    pub(super) const fn remove(&mut self, candidate: CandidateId) {
        self.0 &= !Self::bit(candidate);
    }
}

#[cfg(test)]
mod tests;
