//! Choice of the candidates that the data show, one after the other, each time the likeliest beside those that were
//! chosen before.

use super::{
    Candidates, MAX_CANDIDATES, MAX_CLAIMED,
    candidate_id::{CandidateId, CandidateSet},
    column_id::Columns,
    entered::Entered,
    matrix::{Beside, Matrix, at_most},
    rules::Rules,
    steadiness::Steadiness,
};
use crate::estimator::real::Real;
use heapless::Vec;

/// Log Bayes factor between two effects below which they are rivals: at 5 one is 150 times likelier.
const RIVALS: f32 = 5.0;
/// Hysteresis in log units: an effect stays taken out until its evidence is this far below that of a new find.
const STAYS: f32 = 3.0;
/// Evidence beyond the least, in multiples of it, that a constant error of a vector sensor needs while the remainder is
/// unexplained: the error may resemble the remainder in part, and the attitude would follow. Under a bias of the gyro
/// that comes and goes, which the library lacks, the largest log Bayes factor of such an error was 17 (40 simulated
/// runs).
const AGAINST_UNNAMED: f32 = 3.0;
/// Candidates that are weighed, and columns that are eliminated, in one piece of work.
const WEIGHED: usize = 6;
const ELIMINATED: usize = 3;

/// Candidates that compete in a round of the choice: all, or where nuisances are named these first, then the effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Competitors {
    All,
    Nuisances,
    Effects,
}

/// Work that the choice needs next.
pub(super) enum Next {
    /// To weigh the candidates that are not chosen yet, from this one on.
    Weigh(usize),
    /// To eliminate the columns of a candidate.
    Eliminate,
    /// Nothing: all that the data show is chosen.
    Nothing,
}

/// A candidate that is chosen, and the candidates that were as likely.
#[derive(Clone, Copy)]
pub(super) struct Chosen {
    pub candidate: CandidateId,
    pub rivals: CandidateSet,
}

/// Misfit of the latest innovations.
pub(in crate::estimator) struct Misfit {
    /// Their variance over the one that they should have.
    pub dispersion: f32,
    /// True if they hold more than noise and the claims.
    pub is_unexplained: bool,
}

/// The chosen candidates, and what is known of the others.
pub(in crate::estimator) struct Choice {
    competitors: Competitors,
    pub(super) rules: Rules,
    dispersion: f32,
    /// Evidence that a new claim about a vector sensor needs beyond the least, log units.
    against_unnamed: f32,
    /// True if an error of a vector sensor shows for which the library has no name.
    pub is_unnamed: bool,
    pub(super) entered: Entered,
    /// Columns to be eliminated next.
    entering: Columns,
    chosen: Vec<Chosen, MAX_CLAIMED>,
    /// Candidates that were chosen and turned out to be worth less than the least beside the others.
    dropped: CandidateSet,
    /// Log Bayes factors when the last candidate was chosen.
    pub tried: [f32; MAX_CANDIDATES],
    /// The likeliest of the candidates that were weighed last, and its log Bayes factor.
    best: Option<(CandidateId, f32)>,
}

impl Choice {
    pub const fn zero() -> Self {
        Self {
            competitors: Competitors::All,
            rules: Rules { least: 0.0, with_nuisances: false },
            dispersion: 0.0,
            against_unnamed: 0.0,
            is_unnamed: false,
            entered: Entered::zero(),
            entering: Columns::NONE,
            chosen: Vec::new(),
            dropped: CandidateSet::EMPTY,
            tried: [0.0; MAX_CANDIDATES],
            best: None,
        }
    }

    /// Begins a weighing.
    pub(super) fn start(&mut self, rules: &Rules, Misfit { dispersion, is_unexplained }: Misfit) {
        self.rules = *rules;
        self.against_unnamed = if is_unexplained { AGAINST_UNNAMED * rules.least } else { 0.0 };
        self.dispersion = dispersion;
        self.is_unnamed = false;
        self.dropped = CandidateSet::EMPTY;
        self.begin();
    }

    /// Begins anew without a candidate that the others explain as well: it was chosen too early.
    pub(super) fn begin_without(&mut self, candidate: CandidateId) {
        self.dropped.insert(candidate);
        self.is_unnamed = false;
        self.begin();
    }

    fn begin(&mut self) {
        self.competitors = if self.rules.with_nuisances { Competitors::Nuisances } else { Competitors::All };
        self.entered.clear();
        self.chosen.clear();
    }

    /// Least variance of the data over their stated variance by which evidence is divided.
    pub(super) const fn least_dispersion(&self) -> f32 {
        if self.dispersion > 1.0 { self.dispersion } else { 1.0 }
    }

    pub(super) fn chosen(&self, index: usize) -> Option<Chosen> {
        self.chosen.get(index).copied()
    }

    pub(super) fn is_chosen(&self, candidate: CandidateId) -> bool {
        self.chosen.iter().any(|chosen| chosen.candidate == candidate)
    }

    /// The chosen candidates.
    pub(super) fn all_chosen(&self) -> CandidateSet {
        let mut all = CandidateSet::EMPTY;
        self.chosen.iter().for_each(|chosen| all.insert(chosen.candidate));
        all
    }

    /// Weighs some candidates, from the given one on, and chooses the likeliest once all are weighed.
    #[inline(never)]
    pub(super) fn weigh<T: Real, const E: usize>(
        &mut self,
        matrix: &Matrix<T>,
        from: usize,
        candidates: &Candidates<T, E>,
        steadiness: &Steadiness,
    ) -> Next {
        // Vector sensors' errors that the library has no name for are always eliminated.
        for candidate in candidates.nameless().filter(|_| from == 0) {
            let columns = candidates.columns_of(candidate);
            let fresh = self.entered.others(columns);
            if !fresh.is_empty() {
                let beside = Beside::new(matrix, &fresh, self.entered.count());
                let factor = beside.and_then(|beside| beside.evidence(None));
                self.is_unnamed |= factor.is_some_and(|factor| factor >= self.rules.least);
                return self.eliminate(columns);
            }
        }
        if from == 0 {
            self.best = None;
        }
        let count = candidates.named_count();
        let to = at_most(from + WEIGHED, count);
        for candidate in (from..to).map(CandidateId::new) {
            let factor = self.factor(matrix, candidate, candidates, steadiness);
            let Some(tried) = self.tried.get_mut(candidate.number()) else { break };
            *tried = factor.unwrap_or(0.0);
            let Some(factor) = factor else { continue };
            if factor >= self.rules.least && self.best.is_none_or(|(_, most)| factor > most) {
                self.best = Some((candidate, factor));
            }
        }
        if to < count { Next::Weigh(to) } else { self.choose(candidates) }
    }

    /// Log Bayes factor of a candidate beside the chosen ones. `None` if it does not compete, or the data say nothing
    /// of it.
    fn factor<T: Real, const E: usize>(
        &self,
        matrix: &Matrix<T>,
        candidate: CandidateId,
        candidates: &Candidates<T, E>,
        steadiness: &Steadiness,
    ) -> Option<f32> {
        let columns = candidates.columns_of(candidate);
        let competes = match self.competitors {
            Competitors::All => true,
            Competitors::Nuisances => columns.are_nuisances(),
            Competitors::Effects => !columns.are_nuisances(),
        };
        let fresh = self.entered.others(columns);
        if !competes || self.dropped.has(candidate) || self.is_chosen(candidate) || fresh.is_empty() {
            return None;
        }
        let done = self.entered.count();
        let factor = Beside::new(matrix, &fresh, done)?.evidence(candidates.sign(candidate))?;
        let own = self.dispersion_of(candidate, candidates, steadiness);
        Some(factor / own + self.credit(candidate, candidates) - candidates.chances(candidate))
    }

    /// Chooses the likeliest of the candidates that were weighed, with its rivals.
    fn choose<T: Real, const E: usize>(&mut self, candidates: &Candidates<T, E>) -> Next {
        let least = self.rules.least;
        // A candidate that was as likely as the one chosen before, and says nothing more beside it, is its alias.
        if let Some(last) = self.chosen.last_mut() {
            for candidate in candidates.named() {
                if self.tried.get(candidate.number()).is_some_and(|tried| *tried >= least) {
                    last.rivals.remove(candidate);
                }
            }
        }
        match self.best {
            Some((candidate, _)) if !self.chosen.is_full() => {
                let most = self.tried.get(candidate.number()).copied().unwrap_or(0.0);
                let mut rivals = CandidateSet::EMPTY;
                for (other, tried) in candidates.named().zip(&self.tried) {
                    if other != candidate && *tried >= least && *tried > most - RIVALS {
                        rivals.insert(other);
                    }
                }
                let columns = candidates.columns_of(candidate);
                // A chosen candidate whose columns are part of this one's is no candidate of its own any more.
                self.chosen.retain(|other| !candidates.columns_of(other.candidate).are_within(columns));
                let _ = self.chosen.push(Chosen { candidate, rivals });
                self.eliminate(columns)
            }
            _ if self.competitors == Competitors::Nuisances => {
                self.competitors = Competitors::Effects;
                self.eliminate(Columns::NUISANCES)
            }
            _ => Next::Nothing,
        }
    }

    fn eliminate(&mut self, columns: Columns) -> Next {
        self.entering = columns;
        Next::Eliminate
    }

    /// Eliminates some of the columns that are not eliminated yet; returns true if more are left.
    pub(super) fn enter<T: Real>(&mut self, matrix: &mut Matrix<T>) -> bool {
        for _ in 0..ELIMINATED {
            if let Some(column) = self.entering.next() {
                self.entered.enter(matrix, column);
            }
        }
        !self.entering.is_empty()
    }

    /// Variance of the data over their stated variance, as far as they speak for a candidate: divides its evidence.
    /// 1 for a bias step: the step itself has made the innovations large, and until it is found the estimated bias
    /// follows them.
    pub(super) fn dispersion_of<T: Real, const E: usize>(
        &self,
        candidate: CandidateId,
        candidates: &Candidates<T, E>,
        steadiness: &Steadiness,
    ) -> f32 {
        if candidates.is_step_of(candidate) {
            return 1.0;
        }
        let own = steadiness.dispersion(candidate);
        if self.dispersion > own { self.dispersion } else { own }
    }

    /// Credit, log units: positive for an effect that was found in an earlier session or is taken out now, negative for
    /// a vector sensor's error while the remainder is unexplained. What the restored prior alone says against an effect
    /// does not count: it is narrower than the usual one, and data have not spoken.
    pub(super) fn credit<T: Real, const E: usize>(&self, candidate: CandidateId, candidates: &Candidates<T, E>) -> f32 {
        if candidates.columns_of(candidate).are_nuisances() {
            return -self.against_unnamed;
        }
        let stays = if candidates.is_taken_out(candidate) { STAYS } else { 0.0 };
        match candidates.restored(candidate) {
            Some(evidence) if evidence < 0.0 => stays + self.rules.least - evidence,
            Some(_) => stays + self.rules.least,
            None => stays,
        }
    }
}
