//! Weighing of all effects, piece by piece: each candidate's Bayes factor comes from the root, without a pass over any
//! data. `choice.rs` chooses, `account.rs` holds the claims of the chosen.
//!
//! The root is brought into the order (gyro, nuisances, effects), and the gyro's rows are left out: the others say all
//! that the data tell of nuisances and effects whatever the gyro's parameters are, with their priors. An effect that is
//! chosen has its columns eliminated from the rows that are left. An effect that is not chosen is zero; its columns C
//! and the constants z there give its log Bayes factor: with L = C^T C and s = C^T z, (s^T L^-1 s - log det L) / 2.

use super::{
    Candidates,
    account::Account,
    candidate_id::CandidateId,
    choice::{Choice, Misfit, Next},
    claims::Units,
    column_id::ColumnId,
    entered::Posterior,
    matrix::{Beside, Matrix, at_most, load},
    rules::Rules,
    steadiness::Steadiness,
    unturned::{Hidden, Unturned},
};
use crate::estimator::{
    columns::NUISANCES,
    globals::Globals,
    real::Real,
    rows::{ReferenceRows, SCRATCH, WIDTH},
};

/// Columns that are loaded in one piece of work.
const LOADED: usize = 24;
/// Units of work of the pieces, as [`Probe::poll`](crate::Probe::poll) counts them.
const LOADING_UNITS: u32 = 450;
const CHOOSING_UNITS: u32 = 300;
const ENTERING_UNITS: u32 = 300;
const CLAIMING_UNITS: u32 = 280;
const WATCHING_UNITS: u32 = 230;
const JOINING_UNITS: u32 = 300;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    Loading(usize),
    /// Replaces what the data seem to say of columns of which only a declared field tells.
    Hiding,
    /// Weighs the candidates that are not chosen yet, from this one on.
    Choosing(usize),
    /// Eliminates the columns of the chosen candidate.
    Entering,
    /// Reports the chosen candidates, one after the other.
    Claiming(usize),
    /// Scores the steadiness of the estimates, candidate by candidate.
    Watching(usize),
    /// Computes the covariance of what is taken out, row by row.
    Joining(usize),
}

/// The weighing of all effects, in pieces.
pub(in crate::estimator) struct Evidence<T> {
    stage: Stage,
    steadiness: Steadiness,
    hidden: Hidden<T>,
    pub choice: Choice,
    pub account: Account<T>,
    /// Squared length of the residual that effects and nuisances can explain: before any is chosen, and beside the
    /// claims.
    pub residual: [T; 2],
}

impl<T: Real> Evidence<T> {
    pub const fn zero() -> Self {
        Self {
            stage: Stage::Idle,
            steadiness: Steadiness::zero(),
            hidden: Hidden::zero(),
            choice: Choice::zero(),
            account: Account::zero(),
            residual: [T::ZERO; 2],
        }
    }

    /// Forgets all claims, how steady they were, and all else that a weighing found.
    pub fn clear(&mut self) {
        *self = Self::zero();
    }

    /// Rows of the declared field in the weighing before.
    pub const fn reference(&self) -> Option<ReferenceRows<T>> {
        self.hidden.reference()
    }

    /// Begins a weighing, see [`Choice::start`].
    pub fn start<const E: usize>(
        &mut self,
        rules: &Rules,
        misfit: Misfit,
        unturned: Unturned<T>,
        candidates: &Candidates<T, E>,
    ) {
        self.stage = Stage::Loading(0);
        let (claims, is_referred) = (&self.account.claims, unturned.reference.is_some());
        let is_known = |candidate: CandidateId| {
            !is_referred && candidates.restored(candidate).is_some()
                || claims.iter().any(|known| usize::from(known.effect) == candidate.number())
        };
        let is_claimed = |column: ColumnId| {
            candidates.named().any(|candidate| is_known(candidate) && candidates.columns_of(candidate).has(column))
        };
        self.hidden.choose(unturned, is_claimed);
        self.choice.start(rules, misfit);
    }

    /// Work units of the next piece.
    pub const fn units(&self) -> u32 {
        match self.stage {
            Stage::Loading(_) => LOADING_UNITS,
            Stage::Choosing(_) => CHOOSING_UNITS,
            Stage::Hiding | Stage::Entering => ENTERING_UNITS,
            Stage::Claiming(_) => CLAIMING_UNITS,
            Stage::Watching(_) => WATCHING_UNITS,
            Stage::Joining(_) => JOINING_UNITS,
            Stage::Idle => 1,
        }
    }

    /// One piece of the weighing; returns `false` when it is done. The rows must not change between the pieces.
    pub fn step<const E: usize>(
        &mut self,
        (rows, further): (&mut [[T; WIDTH]; SCRATCH], &mut [[T; E]; SCRATCH]),
        globals: &Globals<T>,
        candidates: &Candidates<T, E>,
        units: &Units<T>,
    ) -> bool {
        let size = NUISANCES + candidates.places().len();
        let mut matrix = Matrix::new(size, rows.as_flattened_mut(), further.as_flattened_mut());
        let (choice, account) = (&mut self.choice, &mut self.account);
        self.stage = match self.stage {
            Stage::Idle => Stage::Idle,
            Stage::Loading(from) => {
                self.hidden.start();
                let to = at_most(from + LOADED, size + 1);
                load(&mut matrix, from..to, globals, candidates);
                if to > size { Stage::Hiding } else { Stage::Loading(to) }
            }
            Stage::Hiding => {
                if self.hidden.hide(&mut matrix, &globals.x, choice.least_dispersion()) {
                    Stage::Hiding
                } else {
                    self.residual[0] = matrix.dot(size, size, 0);
                    choice.entered.begin_with(self.hidden.of_matrix());
                    Stage::Choosing(0)
                }
            }
            Stage::Choosing(from) => match choice.weigh(&matrix, from, candidates, &self.steadiness) {
                Next::Weigh(to) => Stage::Choosing(to),
                Next::Eliminate => Stage::Entering,
                Next::Nothing => {
                    self.residual[1] = matrix.dot(size, size, choice.entered.count());
                    account.clear();
                    Stage::Claiming(0)
                }
            },
            Stage::Entering => {
                if choice.enter(&mut matrix) {
                    Stage::Entering
                } else {
                    Stage::Choosing(0)
                }
            }
            Stage::Claiming(index) => {
                if let Some(chosen) = choice.chosen(index) {
                    account.claim(&matrix, chosen, choice, candidates, &self.steadiness, units);
                    Stage::Claiming(index + 1)
                } else if let Some(candidate) = account.below(choice.rules.least) {
                    choice.begin_without(candidate);
                    Stage::Loading(0)
                } else {
                    Stage::Watching(0)
                }
            }
            Stage::Watching(index) => self.watch(&matrix, index, candidates),
            Stage::Joining(row) => {
                if account.join(&matrix, row, &choice.entered) {
                    Stage::Joining(row + 1)
                } else {
                    Stage::Idle
                }
            }
        };
        self.stage != Stage::Idle
    }

    /// Scores the steadiness of one candidate, chosen or not: its earlier estimate against what was learnt since.
    #[inline(never)]
    fn watch<const E: usize>(&mut self, matrix: &Matrix<T>, index: usize, candidates: &Candidates<T, E>) -> Stage {
        let (choice, candidate) = (&self.choice, CandidateId::new(index));
        if index == 0 {
            self.steadiness.start(choice.all_chosen());
        }
        if index >= candidates.named_count() {
            return Stage::Joining(0);
        }
        let next = Stage::Watching(index + 1);
        if candidates.is_step_of(candidate) {
            return next;
        }
        let columns = candidates.columns_of(candidate);
        let place = candidates.places.first_parameter_of(candidate.number());
        if choice.is_chosen(candidate) {
            let Posterior { mean, covariance } = choice.entered.posterior(matrix, columns);
            let variances = covariance.iter().enumerate().filter_map(|(i, row)| row.get(i));
            let both = mean.iter().zip(variances).take(columns.len());
            self.steadiness.note(candidate, place, both.map(|(mean, variance)| (mean.narrow(), variance.narrow())));
        } else {
            let others = choice.entered.others(columns);
            let beside = if others.len() == columns.len() && !others.is_empty() {
                Beside::new(matrix, &others, choice.entered.count())
            } else {
                None
            };
            if let Some(beside) = beside {
                self.steadiness.note(candidate, place, beside.estimate());
            }
        }
        next
    }
}
