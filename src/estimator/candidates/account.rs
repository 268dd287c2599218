//! Account of the chosen candidates: the claim that each makes, and the columns that are taken out.

use super::{
    Candidates, MAX_CLAIMED, MAX_TAKEN,
    candidate_id::CandidateId,
    choice::{Choice, Chosen},
    claims::{Claim, Units},
    column_id::ColumnId,
    entered::{Entered, Posterior},
    matrix::{Matrix, at_most},
    size,
    steadiness::Steadiness,
};
use crate::{compensation::effect::MAX_PARAMETERS, estimator::real::Real};
use heapless::Vec;

/// The claims, and what is taken out.
pub(in crate::estimator) struct Account<T> {
    pub claims: Vec<Claim, MAX_CLAIMED>,
    /// The candidate with the least evidence, and that evidence with its credit.
    weakest: Option<(CandidateId, f32)>,
    /// Columns that are taken out, their mean and its packed covariance.
    pub taken: Vec<ColumnId, MAX_TAKEN>,
    pub mean: [T; MAX_TAKEN],
    pub covariance: [T; MAX_TAKEN * (MAX_TAKEN + 1) / 2],
    /// Factor by which each deviation is inflated: the root of the dispersion, as far as the prior's deviation allows.
    inflation: [T; MAX_TAKEN],
}

/// Factor by which the variance of one parameter is inflated where the data vary by more than they state. The inflated
/// variance stays within the prior's, which is 1.
fn dispersed<T: Real>(posterior: &Posterior<T>, parameter: usize, dispersion: T) -> T {
    let variance = posterior.covariance.get(parameter).and_then(|row| row.get(parameter)).copied().unwrap_or(T::ONE);
    if dispersion * variance <= T::ONE {
        dispersion
    } else if variance < T::ONE {
        T::ONE / variance
    } else {
        T::ONE
    }
}

impl<T: Real> Account<T> {
    pub const fn zero() -> Self {
        Self {
            claims: Vec::new(),
            weakest: None,
            taken: Vec::new(),
            mean: [T::ZERO; MAX_TAKEN],
            covariance: [T::ZERO; MAX_TAKEN * (MAX_TAKEN + 1) / 2],
            inflation: [T::ZERO; MAX_TAKEN],
        }
    }

    /// Forgets all claims.
    pub(super) fn clear(&mut self) {
        self.claims.clear();
        self.weakest = None;
        self.taken.clear();
    }

    /// The weakest of the claimed candidates, if its evidence is below the least.
    pub(super) fn below(&self, least: f32) -> Option<CandidateId> {
        self.weakest.filter(|(_, evidence)| *evidence < least).map(|(candidate, _)| candidate)
    }

    /// Adds the claim of a chosen candidate.
    #[inline(never)]
    pub(super) fn claim<const E: usize>(
        &mut self,
        matrix: &Matrix<T>,
        Chosen { candidate, rivals }: Chosen,
        choice: &Choice,
        candidates: &Candidates<T, E>,
        steadiness: &Steadiness,
        units: &Units<T>,
    ) {
        let columns = candidates.columns_of(candidate);
        let n = at_most(columns.len(), MAX_PARAMETERS);
        let posterior = choice.entered.posterior(matrix, columns);
        let own = choice.dispersion_of(candidate, candidates, steadiness);
        let scales: [T; MAX_PARAMETERS] = core::array::from_fn(|k| dispersed(&posterior, k, T::of(own)).root());
        // The size of a restored effect is known: smaller widths of its prior would draw it to zero without data.
        let averaged = if candidates.restored(candidate).is_some() {
            posterior.scaled(&scales)
        } else {
            size::averaged(&posterior, n, T::of(own))
        };
        let Posterior { mean, covariance } = averaged;
        let mut claim = candidates.claim(candidate, &mean, &covariance, units);
        let factor = choice.entered.evidence(columns, &posterior).narrow();
        claim.evidence = factor / own - candidates.chances(candidate);
        let counts = claim.evidence + choice.credit(candidate, candidates);
        if self.weakest.is_none_or(|(_, least)| counts < least) {
            self.weakest = Some((candidate, counts));
        }
        claim.rivals = rivals;
        claim.is_taken_out = counts >= choice.rules.least
            && candidates.is_believed(&claim)
            && !candidates.is_of_either_vector(candidate, rivals);
        if !columns.are_nuisances() && claim.is_taken_out {
            claim.is_taken_out = self.taken.len() + n <= MAX_TAKEN;
            for ((column, mean), scale) in columns.iter().zip(mean).zip(scales).filter(|_| claim.is_taken_out) {
                let slots = (self.mean.get_mut(self.taken.len()), self.inflation.get_mut(self.taken.len()));
                if let (Some(slot), Some(inflation)) = slots {
                    *slot = mean;
                    *inflation = scale;
                }
                // There is room.
                let _ = self.taken.push(column);
            }
        }
        let _ = self.claims.push(claim);
    }

    /// Computes one row of the covariance of what is taken out; returns false beyond the last.
    pub(super) fn join(&mut self, matrix: &Matrix<T>, index: usize, entered: &Entered) -> bool {
        let Some(column) = self.taken.get(index) else { return false };
        let others = self.taken.iter().zip(&self.inflation).take(index + 1);
        let row = self.covariance.iter_mut().skip(index * (index + 1) / 2);
        let own = self.inflation.get(index).copied().unwrap_or(T::ONE);
        for (covariance, (other, dispersion)) in row.zip(others) {
            *covariance = entered.covariance(matrix, *column, *other) * own * *dispersion;
        }
        true
    }
}
