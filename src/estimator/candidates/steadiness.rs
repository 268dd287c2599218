//! Steadiness of the effects' estimates, each scored by later data. If an estimate is right, further data
//! change it with the variance by which its own variance falls; an effect that merely resembles the true cause has
//! larger changes.

use super::{
    MAX_CANDIDATES, PARAMETERS,
    candidate_id::{CandidateId, CandidateSet},
};

/// Share of its variance that an estimate has to lose for its change to count: 200 times what f32's rounding may
/// leave of a difference of variances after as many operations as a column has.
const LEAST_TAUGHT: f32 = 0.02;
/// Changes that are remembered, for each parameter: 100 s of motion or more, as long as the data take to teach so
/// often. Older disturbances may be over.
const REMEMBERED: f32 = 20.0;

/// An estimate and its variance; a variance of 0: none.
#[derive(Clone, Copy)]
struct Estimate {
    mean: f32,
    variance: f32,
}

/// Latest estimates of all effects, and their changes against those that the data should make.
pub(super) struct Steadiness {
    /// Candidates beside which the estimates were made.
    beside: CandidateSet,
    estimates: [Estimate; PARAMETERS],
    /// For each candidate: sum of the squared changes over their variances, and their number.
    changes: [[f32; 2]; MAX_CANDIDATES],
}

impl Steadiness {
    pub const fn zero() -> Self {
        Self {
            beside: CandidateSet::EMPTY,
            estimates: [Estimate { mean: 0.0, variance: 0.0 }; PARAMETERS],
            changes: [[0.0; 2]; MAX_CANDIDATES],
        }
    }

    /// Begins a weighing in which these candidates were chosen. Estimates beside others are forgotten: they do not
    /// compare.
    pub fn start(&mut self, beside: CandidateSet) {
        if beside != self.beside {
            self.beside = beside;
            self.estimates = Self::zero().estimates;
        }
    }

    /// Notes an estimate: means and variances of a candidate's parameters, whose places begin at `from`. The estimate
    /// before stays until enough was taught since: late in a run that takes several weighings.
    pub fn note(&mut self, candidate: CandidateId, from: usize, estimate: impl Iterator<Item = (f32, f32)>) {
        let places = self.estimates.iter_mut().skip(from);
        let Some([sum, count]) = self.changes.get_mut(candidate.number()) else { return };
        let mut most = 0.0;
        for (before, (mean, variance)) in places.zip(estimate) {
            most += REMEMBERED;
            let taught = before.variance - variance;
            if taught > LEAST_TAUGHT * variance {
                let change = mean - before.mean;
                *sum += change * change / taught;
                *count += 1.0;
            } else if taught >= 0.0 {
                continue;
            }
            // Also where the variance grew: then there is nothing to compare.
            *before = Estimate { mean, variance };
        }
        if *count > most {
            let kept = most / *count;
            *sum *= kept;
            *count *= kept;
        }
    }

    /// Variance of an effect's changes by further data over the one that it should have; never below 1.
    pub fn dispersion(&self, candidate: CandidateId) -> f32 {
        match self.changes.get(candidate.number()) {
            Some([sum, count]) if *sum > *count => *sum / *count,
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests;
