//! Sizes that the data show, and those that they do not.

use super::*;
use crate::algebra::cholesky::Cholesky;

/// The posterior of data `y = x + noise` of these deviations under the prior N(0, 1).
fn posterior(y: [f64; 3], deviations: [f64; 3]) -> Posterior<f64> {
    let mut posterior = Posterior { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
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
