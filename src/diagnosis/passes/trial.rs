//! The sign-flip test of some columns beside a model, piece by piece.

use crate::{
    compensation::effect::MAX_PARAMETERS,
    diagnosis::{
        sign_flip::{GROUPS, Scores, SignFlip},
        whitening::Whitening,
    },
};

/// Patterns of signs that are counted in one piece of work.
const PATTERNS_IN_A_STEP: u32 = 512;

/// What some columns show beside a model, while it is tested.
pub(super) struct Trial {
    pub is_under_way: bool,
    /// The columns' scores, group by group, cleared of what the model explains; and the information that they have beside the model.
    pub scores: Scores,
    pub whitening: Whitening,
    pub whitened: Scores,
    flip: SignFlip,
}

impl Trial {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            is_under_way: false,
            scores: [[0.0; MAX_PARAMETERS]; GROUPS],
            whitening: Whitening::zero(),
            whitened: [[0.0; MAX_PARAMETERS]; GROUPS],
            flip: SignFlip::zero(),
        }
    }

    /// What is under way is not gone on with.
    pub fn drop_unfinished(&mut self) {
        self.is_under_way = false;
    }

    #[inline(never)]
    pub fn start(&mut self, dimension: usize) {
        self.whitened = self.whitening.whitened(&self.scores);
        self.flip.start(&self.whitened, dimension);
        self.is_under_way = true;
    }

    /// One piece of the test; twice the gain and the p-value when it is done.
    pub fn step(&mut self) -> Option<(f32, f32)> {
        let found = self.flip.count(PATTERNS_IN_A_STEP);
        self.is_under_way = found.is_none();
        found
    }
}
