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
/// Least variance, in squared widths of the prior: rounding may leave less, or a negative one.
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
mod tests {
    use super::*;
    use crate::algebra::cholesky::Cholesky;

    /// The posterior of data `y = x + noise` of these deviations under the prior N(0, 1).
    fn posterior(y: [f64; 3], deviations: [f64; 3]) -> Posterior<f64> {
        let mut posterior =
            Posterior { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
        for k in 0..3 {
            let information = 1.0 / (deviations[k] * deviations[k]);
            posterior.covariance[k][k] = 1.0 / (1.0 + information);
            posterior.mean[k] = y[k] * information * posterior.covariance[k][k];
        }
        posterior
    }

    #[test]
    fn what_the_data_do_not_show_is_as_large_as_what_they_show() {
        // Two parameters of a hundredth of the usual size, and a third that hardly shows.
        let small = posterior([0.01, -0.012, 0.5], [1e-4, 1e-4, 0.7]);
        assert!(small.mean[2] > 0.3, "the data sheet alone allows it: {}", small.mean[2]);
        let averaged_small = averaged(&small, 3, 1.0);
        assert!(averaged_small.mean[2].abs() < 0.01, "{}", averaged_small.mean[2]);
        assert!(averaged_small.covariance[2][2].sqrt() < 0.05, "{}", averaged_small.covariance[2][2]);
        for k in 0..2 {
            assert!((averaged_small.mean[k] - small.mean[k]).abs() < 1e-4);
        }
        // At the usual size, all stays as it was.
        let large = posterior([1.0, -1.2, 0.5], [1e-3, 1e-3, 0.7]);
        let averaged_large = averaged(&large, 3, 1.0);
        assert!((averaged_large.mean[2] / large.mean[2] - 1.0).abs() < 0.2);
    }

    #[test]
    fn a_correlated_posterior_comes_back_where_one_width_has_all_the_evidence() {
        // Three well known parameters of the usual size, correlated: widths below 1 have no evidence.
        let root: [[f64; 3]; 3] = [[0.02, 0.0, 0.0], [0.01, 0.03, 0.0], [-0.01, 0.02, 0.02]];
        let mut known = Posterior { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
        known.mean[..3].copy_from_slice(&[4.0, -5.0, 3.0]);
        for i in 0..3 {
            for j in 0..3 {
                known.covariance[i][j] = (0..3).map(|k| root[i][k] * root[j][k]).sum();
            }
        }
        let back = averaged(&known, 3, 1.0);
        for i in 0..3 {
            assert!((back.mean[i] - known.mean[i]).abs() < 1e-2, "{i}: {}", back.mean[i]);
            for j in 0..3 {
                assert!((back.covariance[i][j] - known.covariance[i][j]).abs() < 2e-5, "{i} {j}");
            }
        }
        // It is a covariance: it has a factor. Data that have four times their variance tell half as closely.
        let factor = Cholesky::<f64, MAX_PARAMETERS>::new(3, |i, j| back.covariance[i][j]);
        assert!(factor.is_some());
        let louder = averaged(&known, 3, 4.0);
        assert!((louder.covariance[0][0] / back.covariance[0][0] - 4.0).abs() < 0.05);
    }
    /// Two parameters of which the data show the difference alone, in `f32`: rounding may make a variance negative.
    #[test]
    fn a_variance_that_rounding_made_negative_moves_no_mean() {
        let mut known =
            Posterior::<f32> { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
        known.mean[..2].copy_from_slice(&[0.5, 0.501]);
        let [one, more] = [0.05_f32, 0.050_000_004];
        known.covariance[0][..2].copy_from_slice(&[one, more]);
        known.covariance[1][..2].copy_from_slice(&[more, one]);
        let back = averaged(&known, 2, 1.0);
        for k in 0..2 {
            assert!((0.0..0.55).contains(&back.mean[k]), "{:?}", back.mean);
            assert!(back.covariance[k][k].is_finite() && back.covariance[k][k] >= 0.0);
        }
    }
}
