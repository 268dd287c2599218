//! Choice of the effects that the data show: each claim's Bayes factor comes from the root, without a pass over any
//! data.
//!
//! The root is brought into the order (gyro, nuisances, effects), and the gyro's rows are left out: the others say all
//! that the data tell of nuisances and effects whatever the gyro's parameters are, with their priors. An effect that is
//! chosen has its columns eliminated from the rows that are left. An effect that is not chosen is zero; its columns C
//! and the constants z there give its log Bayes factor: with L = C^T C and s = C^T z, (s^T L^-1 s - log det L) / 2.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    Candidates, MAX_CLAIMED, MAX_CLAIMS, MAX_TAKEN,
    claims::{Claim, Units},
    entered::{Entered, Posterior},
    matrix::{Beside, Matrix, at_most, load, savage_dickey},
    rules::Rules,
    size,
    steadiness::Steadiness,
    unturned::{IronAlone, Unturned},
};
use crate::{
    compensation::effect::MAX_PARAMETERS,
    estimator::{columns::NUISANCES, globals::Globals, real::Real, rows::WIDTH, update::SCRATCH},
};
use core::ops::Range;
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
/// Columns that are loaded, or eliminated, in one piece of work.
const LOADED: usize = 24;
const ELIMINATED: usize = 3;
/// Claims that are weighed in one piece.
const WEIGHED: usize = 6;
/// Work units of the pieces, as those of `crate::estimator::work`.
const LOADING_UNITS: u32 = 450;
const CHOOSING_UNITS: u32 = 300;
const ENTERING_UNITS: u32 = 300;
const TELLING_UNITS: u32 = 280;
const WATCHING_UNITS: u32 = 230;
const JOINING_UNITS: u32 = 300;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    Loading(usize),
    /// Weighs the claims that are not chosen yet, from this one on.
    Choosing(usize),
    /// Eliminates the columns of the chosen claim, from this one on.
    Entering(usize),
    /// Reports the chosen effects, one after the other.
    Telling(usize),
    /// Scores the steadiness of the estimates, claim by claim.
    Watching(usize),
    /// Computes the covariance of what is taken out, row by row.
    Joining(usize),
}

/// Claims that compete now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Competitors {
    All,
    Nuisances,
    Effects,
}

/// The weighing of all effects, in pieces.
pub(in crate::estimator) struct Evidence<T> {
    stage: Stage,
    competitors: Competitors,
    rules: Rules,
    steadiness: Steadiness,
    dispersion: f32,
    /// Evidence that a new claim about a vector sensor needs beyond the least, log units.
    against_unnamed: f32,
    pub unturned: Unturned,
    /// True if an error of a vector sensor shows for which the library has no name.
    pub is_unnamed: bool,
    entered: Entered,
    /// Columns to be eliminated next.
    entering: Range<usize>,
    chosen: Vec<Chosen, MAX_CLAIMED>,
    /// Claims that were chosen and turned out to be worth less than the least beside the others, one bit each.
    dropped: u32,
    /// Log Bayes factors when the last claim was chosen.
    pub tried: [f32; MAX_CLAIMS],
    pub claims: Vec<Claim, MAX_CLAIMED>,
    /// The likeliest of the claims that were weighed last, and its log Bayes factor as it ranks: by what the data say of
    /// it, because other claims may say the same of a field along an axis that has not turned, and no declared field
    /// limits them. What counts stands in `tried`.
    best: Option<(u8, f32)>,
    /// The claim with the least evidence, and that evidence with its credit.
    weakest: Option<(u8, f32)>,
    /// Columns that are taken out, their mean and its packed covariance.
    pub taken: Vec<u8, MAX_TAKEN>,
    pub mean: [T; MAX_TAKEN],
    pub covariance: [T; MAX_TAKEN * (MAX_TAKEN + 1) / 2],
    /// Squared length of the residual that effects and nuisances can explain: before any is chosen, and beside the
    /// claims.
    pub residual: [T; 2],
}

#[derive(Clone, Copy)]
struct Chosen {
    claim: u8,
    rivals: u32,
}

impl<T: Real> Evidence<T> {
    pub const fn zero() -> Self {
        Self {
            stage: Stage::Idle,
            competitors: Competitors::All,
            rules: Rules { least: 0.0, with_nuisances: false },
            steadiness: Steadiness::zero(),
            dispersion: 0.0,
            against_unnamed: 0.0,
            unturned: Unturned::NONE,
            is_unnamed: false,
            entered: Entered::zero(),
            entering: 0..0,
            chosen: Vec::new(),
            dropped: 0,
            tried: [0.0; MAX_CLAIMS],
            claims: Vec::new(),
            best: None,
            weakest: None,
            taken: Vec::new(),
            mean: [T::ZERO; MAX_TAKEN],
            covariance: [T::ZERO; MAX_TAKEN * (MAX_TAKEN + 1) / 2],
            residual: [T::ZERO; 2],
        }
    }

    /// Forgets all claims, and how steady they were.
    pub fn clear(&mut self) {
        self.steadiness = Steadiness::zero();
        self.stage = Stage::Idle;
        self.claims.clear();
        self.taken.clear();
    }

    /// Begins a weighing. `dispersion`: variance of the latest innovations over the one that they should have.
    /// `is_unexplained`: true if they hold more than noise and the claims.
    pub fn start(&mut self, rules: &Rules, dispersion: f32, is_unexplained: bool) {
        self.stage = Stage::Loading(0);
        self.rules = *rules;
        self.against_unnamed = if is_unexplained { AGAINST_UNNAMED * rules.least } else { 0.0 };
        self.dispersion = dispersion;
        self.is_unnamed = false;
        self.dropped = 0;
        self.begin();
    }

    fn begin(&mut self) {
        self.competitors = if self.rules.with_nuisances { Competitors::Nuisances } else { Competitors::All };
        self.entered.clear();
        self.chosen.clear();
    }

    /// Work units of the next piece.
    pub const fn units(&self) -> u32 {
        match self.stage {
            Stage::Loading(_) => LOADING_UNITS,
            Stage::Choosing(_) => CHOOSING_UNITS,
            Stage::Entering(_) => ENTERING_UNITS,
            Stage::Telling(_) => TELLING_UNITS,
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
        let size = NUISANCES + candidates.columns;
        let mut matrix = Matrix::new(size, rows.as_flattened_mut(), further.as_flattened_mut());
        match self.stage {
            Stage::Idle => {}
            Stage::Loading(from) => {
                let to = if from + LOADED < size + 1 { from + LOADED } else { size + 1 };
                load(&mut matrix, from..to, globals, candidates);
                self.stage = if to > size { Stage::Choosing(0) } else { Stage::Loading(to) };
                if to > size {
                    self.residual[0] = matrix.dot(size, size, 0);
                }
            }
            Stage::Choosing(claim) => self.choose(&matrix, claim, candidates),
            Stage::Telling(chosen) => self.tell(&matrix, chosen, candidates, units),
            Stage::Watching(claim) => self.watch(&matrix, claim, candidates),
            Stage::Joining(row) => self.join(&matrix, row),
            Stage::Entering(next) => {
                let mut next = next;
                for _ in 0..ELIMINATED {
                    if next < self.entering.end {
                        self.entered.enter(&mut matrix, next);
                        next += 1;
                    }
                }
                self.stage = if next < self.entering.end { Stage::Entering(next) } else { Stage::Choosing(0) };
            }
        }
        self.stage != Stage::Idle
    }

    #[inline(never)]
    fn choose<const E: usize>(&mut self, matrix: &Matrix<T>, from: usize, candidates: &Candidates<T, E>) {
        // Vector sensors' errors that the library has no name for are always eliminated.
        let unnamed = candidates.named_claims()..candidates.claims();
        for claim in unnamed.filter(|_| from == 0) {
            let columns = candidates.columns_of(claim);
            let fresh = self.entered.others(columns.clone());
            if !fresh.is_empty() {
                let beside = Beside::new(matrix, &fresh, self.entered.count());
                let factor = beside.and_then(|beside| beside.evidence(None));
                self.is_unnamed |= factor.is_some_and(|factor| factor >= self.rules.least);
                self.enter(columns);
                return;
            }
        }
        if let Some(column) = self.next_hidden(candidates).filter(|_| from == 0) {
            self.enter(column..column + 1);
            return;
        }
        let done = self.entered.count();
        if from == 0 {
            self.best = None;
        }
        let to = at_most(from + WEIGHED, candidates.named_claims());
        for claim in from..to {
            let columns = candidates.columns_of(claim);
            let is_nuisance = columns.start < NUISANCES;
            let competes = match self.competitors {
                Competitors::All => true,
                Competitors::Nuisances => is_nuisance,
                Competitors::Effects => !is_nuisance,
            };
            let fresh = self.entered.others(columns);
            let is_out =
                self.dropped >> claim & 1 == 1 || self.chosen.iter().any(|chosen| usize::from(chosen.claim) == claim);
            let is_weighed = competes && !is_out && !fresh.is_empty();
            let beside = if is_weighed { Beside::new(matrix, &fresh, done) } else { None };
            let factor = beside.and_then(|beside| {
                let factor = beside.evidence(candidates.sign(claim))?;
                let own = self.dispersion_of(claim, candidates);
                let alone = self.unturned.beside(matrix, &fresh, done, own);
                let beside_chance = self.credit(claim, candidates) - candidates.chances(claim);
                Some([IronAlone::of_whole(alone, factor, own), factor / own].map(|factor| factor + beside_chance))
            });
            let Some(tried) = self.tried.get_mut(claim) else { break };
            *tried = factor.map_or(0.0, |[counts, _]| counts);
            let Some([counts, ranks]) = factor else { continue };
            if counts >= self.rules.least && self.best.is_none_or(|(_, most)| ranks > most) {
                self.best = Some((claim as u8, ranks));
            }
        }
        if to < candidates.named_claims() {
            self.stage = Stage::Choosing(to);
            return;
        }
        // A claim that was as likely as the one chosen before, and says nothing more beside it, is its alias.
        if let Some(last) = self.chosen.last_mut() {
            for claim in 0..candidates.named_claims() {
                if self.tried.get(claim).is_some_and(|tried| *tried >= self.rules.least) {
                    last.rivals &= !(1 << claim);
                }
            }
        }
        match self.best {
            Some((claim, _)) if !self.chosen.is_full() => {
                let claim = usize::from(claim);
                let most = self.tried.get(claim).copied().unwrap_or(0.0);
                let mut rivals = 0;
                for (other, tried) in self.tried.iter().enumerate().take(candidates.named_claims()) {
                    if other != claim && *tried >= self.rules.least && *tried > most - RIVALS {
                        rivals |= 1 << other;
                    }
                }
                let columns = candidates.columns_of(claim);
                // A chosen claim whose columns are part of this claim's is no claim of its own any more.
                let is_part = |other: &Chosen| {
                    let of = candidates.columns_of(usize::from(other.claim));
                    columns.start <= of.start && of.end <= columns.end
                };
                self.chosen.retain(|other| !is_part(other));
                let _ = self.chosen.push(Chosen { claim: claim as u8, rivals });
                self.enter(columns);
            }
            _ if self.competitors == Competitors::Nuisances => {
                self.competitors = Competitors::Effects;
                self.enter(0..NUISANCES);
            }
            _ => {
                self.residual[1] = matrix.dot(matrix.rows, matrix.rows, done);
                self.claims.clear();
                self.weakest = None;
                self.taken.clear();
                self.stage = Stage::Telling(0);
            }
        }
    }

    /// Variance of the data over their stated variance, as far as they speak for a claim: divides the claim's evidence.
    /// 1 for a bias step: the step itself has made the innovations large, and until it is found the estimated bias
    /// follows them.
    fn dispersion_of<const E: usize>(&self, claim: usize, candidates: &Candidates<T, E>) -> f32 {
        if candidates.is_step_of(claim) {
            return 1.0;
        }
        let own = self.steadiness.dispersion(claim);
        if self.dispersion > own { self.dispersion } else { own }
    }

    /// Next hard-iron column along an axis that has not turned, without a declared field: the column is eliminated
    /// before any claim, unless it was claimed before, when the axis had turned.
    fn next_hidden<const E: usize>(&self, candidates: &Candidates<T, E>) -> Option<usize> {
        let is_claimed = |column: usize| {
            let is_known = |claim: usize| {
                candidates.is_restored(claim) || self.claims.iter().any(|known| usize::from(known.effect) == claim)
            };
            (0..candidates.named_claims())
                .any(|claim| is_known(claim) && candidates.columns_of(claim).contains(&column))
        };
        if self.unturned.is_told() {
            return None;
        }
        self.unturned.columns().find(|column| !self.entered.has(*column) && !is_claimed(*column))
    }

    /// Credit, log units: positive for an effect that was found in an earlier session or is taken out now, negative for
    /// a vector sensor's error while the remainder is unexplained.
    fn credit<const E: usize>(&self, claim: usize, candidates: &Candidates<T, E>) -> f32 {
        let is_nuisance = candidates.columns_of(claim).start < NUISANCES;
        if candidates.is_restored(claim) && !is_nuisance {
            self.rules.least
        } else if candidates.is_taken_out(claim) {
            STAYS
        } else if is_nuisance {
            -self.against_unnamed
        } else {
            0.0
        }
    }

    /// Starts to eliminate an effect's columns that are not eliminated yet.
    fn enter(&mut self, columns: Range<usize>) {
        self.entering = columns;
        self.stage = Stage::Entering(self.entering.start);
    }

    /// Reports one of the chosen effects.
    #[inline(never)]
    fn tell<const E: usize>(
        &mut self,
        matrix: &Matrix<T>,
        index: usize,
        candidates: &Candidates<T, E>,
        units: &Units<T>,
    ) {
        let Some(chosen) = self.chosen.get(index).copied() else {
            // An effect that the others explain as well was chosen too early: the choice begins anew without it.
            self.stage = match self.weakest {
                Some((claim, least)) if least < self.rules.least => {
                    self.dropped |= 1 << claim;
                    self.is_unnamed = false;
                    self.begin();
                    Stage::Loading(0)
                }
                _ => Stage::Watching(0),
            };
            return;
        };
        self.stage = Stage::Telling(index + 1);
        let claim = usize::from(chosen.claim);
        let columns = candidates.columns_of(claim);
        let n = at_most(columns.len(), MAX_PARAMETERS);
        let posterior = self.entered.posterior(matrix, columns.clone());
        let own = self.dispersion_of(claim, candidates);
        let alone = self.unturned.among(&posterior, &columns, own);
        let dispersions = self.unturned.dispersions(&columns, alone, own);
        let Posterior { mean, covariance } = size::averaged(&posterior, n, &dispersions);
        let mut one = candidates.claim(claim, &mean, &covariance, units);
        let factor = savage_dickey(&posterior.mean, &posterior.covariance, n).narrow();
        one.evidence = IronAlone::of_whole(alone, factor, own) - candidates.chances(claim);
        let counts = one.evidence + self.credit(claim, candidates);
        if self.weakest.is_none_or(|(_, least)| counts < least) {
            self.weakest = Some((chosen.claim, counts));
        }
        one.rivals = chosen.rivals;
        one.is_taken_out = counts >= self.rules.least
            && candidates.is_believed(&one)
            && !candidates.is_of_either_vector(claim, chosen.rivals);
        if columns.start >= NUISANCES && one.is_taken_out {
            one.is_taken_out = self.taken.len() + n <= MAX_TAKEN;
            for (column, mean) in columns.zip(mean).filter(|_| one.is_taken_out) {
                if let Some(slot) = self.mean.get_mut(self.taken.len()) {
                    *slot = mean;
                }
                // There is room.
                let _ = self.taken.push(column as u8);
            }
        }
        let _ = self.claims.push(one);
    }

    /// Scores the steadiness of one claim, chosen or not: its earlier estimate against what was learnt since.
    #[inline(never)]
    fn watch<const E: usize>(&mut self, matrix: &Matrix<T>, claim: usize, candidates: &Candidates<T, E>) {
        if claim == 0 {
            self.steadiness.start(self.chosen.iter().fold(0, |bits, chosen| bits | 1 << chosen.claim));
        }
        if claim >= candidates.named_claims() {
            self.stage = Stage::Joining(0);
            return;
        }
        self.stage = Stage::Watching(claim + 1);
        if candidates.is_step_of(claim) {
            return;
        }
        let columns = candidates.columns_of(claim);
        let place = candidates.first_parameter_of(claim);
        if self.chosen.iter().any(|chosen| usize::from(chosen.claim) == claim) {
            let Posterior { mean, covariance } = self.entered.posterior(matrix, columns.clone());
            let variances = covariance.iter().enumerate().filter_map(|(i, row)| row.get(i));
            let both = mean.iter().zip(variances).take(columns.len());
            self.steadiness.note(claim, place, both.map(|(mean, variance)| (mean.narrow(), variance.narrow())));
        } else {
            let others = self.entered.others(columns.clone());
            let beside = if others.len() == columns.len() && !others.is_empty() {
                Beside::new(matrix, &others, self.entered.count())
            } else {
                None
            };
            if let Some(beside) = beside {
                self.steadiness.note(claim, place, beside.estimate());
            }
        }
    }

    /// Computes one row of the covariance of what is taken out.
    fn join(&mut self, matrix: &Matrix<T>, index: usize) {
        let Some(column) = self.taken.get(index).map(|column| usize::from(*column)) else {
            self.stage = Stage::Idle;
            return;
        };
        for other in 0..=index {
            let Some(other_column) = self.taken.get(other).map(|column| usize::from(*column)) else { break };
            if let Some(covariance) = self.covariance.get_mut(index * (index + 1) / 2 + other) {
                *covariance = self.entered.covariance(matrix, column, other_column);
            }
        }
        self.stage = Stage::Joining(index + 1);
    }
}
