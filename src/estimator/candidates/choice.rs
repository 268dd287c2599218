//! Choice of the candidates that the data show, one after the other, each time the likeliest beside those that were
//! chosen before.

use super::{
    Candidates, MAX_CANDIDATES, MAX_CLAIMED,
    candidate_id::{CandidateId, CandidateSet},
    claims::Claim,
    column_id::{ColumnId, Columns},
    entered::Entered,
    matrix::{Beside, Matrix, at_most},
    rules::Rules,
    steadiness::Steadiness,
    unturned::{IronAlone, Unturned},
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

/// Candidates that compete now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Competitors {
    All,
    Nuisances,
    Effects,
}

/// Next piece that the choice wants.
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

/// The chosen candidates, and what is known of the others.
pub(in crate::estimator) struct Choice {
    competitors: Competitors,
    pub(super) rules: Rules,
    dispersion: f32,
    /// Evidence that a new claim about a vector sensor needs beyond the least, log units.
    against_unnamed: f32,
    pub unturned: Unturned,
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
    /// The likeliest of the candidates that were weighed last, and its log Bayes factor as it ranks: by what the data
    /// say of it, because other candidates may say the same of a field along an axis that has not turned, and no
    /// declared field limits them. What counts stands in `tried`.
    best: Option<(CandidateId, f32)>,
}

impl Choice {
    pub const fn zero() -> Self {
        Self {
            competitors: Competitors::All,
            rules: Rules { least: 0.0, with_nuisances: false },
            dispersion: 0.0,
            against_unnamed: 0.0,
            unturned: Unturned::NONE,
            is_unnamed: false,
            entered: Entered::zero(),
            entering: Columns::NONE,
            chosen: Vec::new(),
            dropped: CandidateSet::EMPTY,
            tried: [0.0; MAX_CANDIDATES],
            best: None,
        }
    }

    /// Begins a weighing. `dispersion`: variance of the latest innovations over the one that they should have.
    /// `is_unexplained`: true if they hold more than noise and the claims.
    pub(super) fn start(&mut self, rules: &Rules, dispersion: f32, is_unexplained: bool) {
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

    /// Weighs some candidates, from the given one on, and chooses the likeliest once all are weighed. `claims`: those
    /// of the weighing before.
    #[inline(never)]
    pub(super) fn weigh<T: Real, const E: usize>(
        &mut self,
        matrix: &Matrix<T>,
        from: usize,
        candidates: &Candidates<T, E>,
        claims: &[Claim],
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
        if let Some(column) = self.next_hidden(candidates, claims).filter(|_| from == 0) {
            return self.eliminate(Columns::one(column));
        }
        if from == 0 {
            self.best = None;
        }
        let count = candidates.named_count();
        let to = at_most(from + WEIGHED, count);
        for candidate in (from..to).map(CandidateId::new) {
            let factor = self.factor(matrix, candidate, candidates, steadiness);
            let Some(tried) = self.tried.get_mut(candidate.number()) else { break };
            *tried = factor.map_or(0.0, |[counts, _]| counts);
            let Some([counts, ranks]) = factor else { continue };
            if counts >= self.rules.least && self.best.is_none_or(|(_, most)| ranks > most) {
                self.best = Some((candidate, ranks));
            }
        }
        if to < count { Next::Weigh(to) } else { self.choose(candidates) }
    }

    /// Log Bayes factors of a candidate beside the chosen ones: the one that counts, and the one by which it ranks.
    /// `None` if it does not compete, or the data say nothing of it.
    fn factor<T: Real, const E: usize>(
        &self,
        matrix: &Matrix<T>,
        candidate: CandidateId,
        candidates: &Candidates<T, E>,
        steadiness: &Steadiness,
    ) -> Option<[f32; 2]> {
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
        let alone = self.unturned.beside(matrix, &fresh, done, own);
        let beside_chance = self.credit(candidate, candidates) - candidates.chances(candidate);
        Some([IronAlone::of_whole(alone, factor, own), factor / own].map(|factor| factor + beside_chance))
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

    /// Next hard-iron column along an axis that has not turned, without a declared field: the column is eliminated
    /// before any candidate, unless it was claimed before, when the axis had turned.
    fn next_hidden<T: Real, const E: usize>(
        &self,
        candidates: &Candidates<T, E>,
        claims: &[Claim],
    ) -> Option<ColumnId> {
        let is_known = |candidate: CandidateId| {
            candidates.is_restored(candidate)
                || claims.iter().any(|known| usize::from(known.effect) == candidate.number())
        };
        let is_claimed = |column: ColumnId| {
            candidates.named().any(|candidate| is_known(candidate) && candidates.columns_of(candidate).has(column))
        };
        if self.unturned.is_told() {
            return None;
        }
        self.unturned.hidden().find(|column| !self.entered.has(*column) && !is_claimed(*column))
    }

    /// Credit, log units: positive for an effect that was found in an earlier session or is taken out now, negative for
    /// a vector sensor's error while the remainder is unexplained.
    pub(super) fn credit<T: Real, const E: usize>(&self, candidate: CandidateId, candidates: &Candidates<T, E>) -> f32 {
        let is_nuisance = candidates.columns_of(candidate).are_nuisances();
        if candidates.is_restored(candidate) && !is_nuisance {
            self.rules.least
        } else if candidates.is_taken_out(candidate) {
            STAYS
        } else if is_nuisance {
            -self.against_unnamed
        } else {
            0.0
        }
    }
}
