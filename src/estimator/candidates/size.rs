//! An effect's posterior averaged over the width of its prior: the parameters that the data show say how large those
//! are that they do not show. With the data sheet's width alone a hard iron of 0.2 uT across the tool would leave one
//! of 5 uT along it to chance, and the attitude would follow.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{entered::Posterior, matrix::at_most};
use crate::{
    compensation::effect::MAX_PARAMETERS,
    estimator::{eigen::diagonalise, real::Real},
};

/// Number of widths, each half of the one before, all as likely before the data; 1 is the data sheet's. The
/// least is what quantisation leaves of an error within a data sheet.
const WIDTHS: usize = 8;
/// Least variance of a parameter, in squared widths of its prior: rounding could leave a smaller one, or a negative
/// one.
const LEAST_VARIANCE: f32 = 1e-12;

/// The posterior of `n` parameters in units of their priors' widths, averaged over smaller widths by their evidence.
/// `dispersion`: variance of the data over their stated variance.
#[inline(never)]
pub(super) fn averaged<T: Real>(posterior: &Posterior<T>, n: usize, dispersion: T) -> Posterior<T> {
    // A limit that the compiler knows: no index has to be checked.
    let n = at_most(n, MAX_PARAMETERS);
    let mut diagonal = posterior.covariance;
    let vectors = diagonalise(&mut diagonal);
    // Along each eigenvector: information of the data without the prior, and information times mean.
    let mut information = [T::ZERO; MAX_PARAMETERS];
    let mut weighted = [T::ZERO; MAX_PARAMETERS];
    for k in 0..n {
        let mean = (0..n).fold(T::ZERO, |sum, i| sum + vectors[i][k] * posterior.mean[i]);
        let variance = diagonal[k][k];
        let inverse = T::ONE / if variance > T::of(LEAST_VARIANCE) { variance } else { T::of(LEAST_VARIANCE) };
        information[k] = if inverse > T::ONE { (inverse - T::ONE) / dispersion } else { T::ZERO };
        weighted[k] = mean * inverse / dispersion;
    }
    let mut evidence = [T::ZERO; WIDTHS];
    let mut best = T::ZERO;
    for (w, evidence) in evidence.iter_mut().enumerate() {
        let prior = prior_information(w);
        for k in 0..n {
            let all = information[k] + prior;
            let gain = weighted[k] * weighted[k] / all;
            *evidence += (prior.logarithm() - all.logarithm() + gain) * T::of(0.5);
        }
        if w == 0 || *evidence > best {
            best = *evidence;
        }
    }
    let mut total = T::ZERO;
    for evidence in &mut evidence {
        *evidence = (*evidence - best).exponential();
        total += *evidence;
    }
    let mut mean = [T::ZERO; MAX_PARAMETERS];
    let mut covariance = [[T::ZERO; MAX_PARAMETERS]; MAX_PARAMETERS];
    for (w, evidence) in evidence.iter().enumerate() {
        let weight = *evidence / total;
        let prior = prior_information(w);
        let mut of_width = [T::ZERO; MAX_PARAMETERS];
        for k in 0..n {
            let variance = T::ONE / (information[k] + prior);
            for i in 0..n {
                of_width[i] += vectors[i][k] * weighted[k] * variance;
                for j in 0..n {
                    covariance[i][j] += weight * vectors[i][k] * vectors[j][k] * variance;
                }
            }
        }
        for i in 0..n {
            mean[i] += weight * of_width[i];
            for j in 0..n {
                covariance[i][j] += weight * of_width[i] * of_width[j];
            }
        }
    }
    // Second moments less the square of the mean: never negative.
    for i in 0..n {
        for j in 0..n {
            covariance[i][j] -= mean[i] * mean[j];
        }
    }
    Posterior { mean, covariance }
}

/// Information of a prior of the given place among the widths.
fn prior_information<T: Real>(width: usize) -> T {
    (0..width).fold(T::ONE, |information, _| information * T::of(4.0))
}

#[cfg(test)]
mod tests;
