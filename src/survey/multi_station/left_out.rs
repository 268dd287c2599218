//! Leave-one-out: residuals of each station as the others predict it.

use super::{
    Station,
    fit::Fit,
    rows::{Rows, Scales},
};
use crate::algebra::cholesky::Cholesky;

/// Stations' residuals of a fit, each left out in turn; all in units of the noise.
pub(super) struct LeftOut {
    /// Sum of squared residuals of each counted station as the others predict it.
    pub(super) predicted: f32,
    /// Sum of squared residuals without any correction.
    pub(super) uncorrected: f32,
    /// Sum of squared residuals of the fit itself, over their degrees of freedom.
    pub(super) variance_ratio: f32,
    /// Degrees of freedom: three a station less those that the estimated errors use up.
    pub(super) freedom: f32,
    /// Counted station that the others contradict most, and by how much: chi-square with three degrees of freedom.
    pub(super) worst: Option<(usize, f32)>,
}

/// Predicts each counted station from the others. With the fit linear around its maximum no second fit is needed: if a
/// station has residuals r, with the share H = J S J^T in the fit, the others' prediction errs by (I - H)^-1 r, whose
/// covariance is (I - H)^-1.
pub(super) fn left_out(
    stations: &[Station],
    counts: impl Fn(usize) -> bool,
    scales: &Scales,
    fit: &Fit,
) -> Option<LeftOut> {
    let mut sums = LeftOut { predicted: 0.0, uncorrected: 0.0, variance_ratio: 0.0, freedom: 0.0, worst: None };
    for (k, station) in stations.iter().enumerate().filter(|(k, _)| counts(*k)) {
        let Rows { residual, derivative } = scales.rows(station, &fit.x)?;
        let share = |i: usize, j: usize| match (derivative.get(i), derivative.get(j)) {
            (Some(a), Some(b)) => fit.information.covariance(a, b),
            _ => 0.0,
        };
        let rest = Cholesky::<f32, 3>::new(3, |i, j| f32::from(i == j) - share(i, j))?;
        let mut y = residual;
        rest.solve_lower(&mut y);
        let surprise = square(&y);
        rest.solve_upper(&mut y);
        sums.predicted += square(&y);
        sums.variance_ratio += square(&residual);
        sums.freedom += 3.0 - (share(0, 0) + share(1, 1) + share(2, 2));
        sums.uncorrected += square(&scales.rows(station, &[0.0; super::PARAMETERS])?.residual);
        if sums.worst.is_none_or(|(_, worst)| surprise > worst) {
            sums.worst = Some((k, surprise));
        }
    }
    sums.variance_ratio /= sums.freedom;
    (sums.freedom > 0.0).then_some(sums)
}

fn square(v: &[f32; 3]) -> f32 {
    v.iter().fold(0.0, |sum, x| sum + x * x)
}
