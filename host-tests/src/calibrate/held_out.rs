//! What a calibration is worth on readings that it has not seen.

use super::{
    model::{Model, PARAMETERS},
    norm_fit::{Fit, Observation, Problem},
};

/// Root mean square of the error of the norm on readings held out, in the sensor's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// How they were held out.
    pub how: &'static str,
    /// Number of readings.
    pub count: usize,
    /// With the old values.
    pub before: f64,
    /// With values fitted to the others.
    pub after: f64,
    /// What the readings' own noise alone would leave with the true values.
    pub noise: f64,
    /// The largest error, with values fitted to the others.
    pub largest: f64,
}

/// Stretches into which readings are cut of which neighbours are alike: one that is left out by itself would be checked by another like it.
const STRETCHES: usize = 10;

/// Leaves out one part at a time, fits to the others and checks on it. Rests, which have nothing in common, are left out one by one: half of
/// two dozen would hardly be more than there are parameters, and tell of a worse fit than is made. Readings that the whole fit leaves out do
/// not count.
#[must_use]
pub fn held_out(problem: &Problem, fit: &Fit) -> Option<HeldOut> {
    let used: Vec<usize> = (0..fit.used.len()).filter(|&at| fit.used[at]).collect();
    let (parts, how) = if problem.correlated {
        (STRETCHES.min(used.len()), "fitted to the other stretches")
    } else {
        (used.len(), "fitted to all others")
    };
    let errors = (0..parts).map(|part| {
        let [from, to] = [part, part + 1].map(|part| part * used.len() / parts);
        fitted_without(problem, &used[from..to], &[&used[..from], &used[to..]].concat())
    });
    let errors = errors.collect::<Option<Vec<_>>>()?.concat();
    Some(HeldOut {
        how,
        count: used.len(),
        before: rms(used.iter().map(|&at| norm_error(&problem.record, &problem.observations[at])))?,
        after: rms(errors.iter().copied())?,
        noise: rms(used.iter().map(|&at| problem.observations[at].sigma))?,
        largest: errors.iter().fold(0.0, |largest: f64, error| largest.max(error.abs())),
    })
}

/// Errors of the norm at the readings `out`, with parameters fitted to `others`; `None` if these do not determine all.
fn fitted_without(problem: &Problem, out: &[usize], others: &[usize]) -> Option<Vec<f64>> {
    let kept: Vec<Observation> = others.iter().map(|&at| problem.observations[at]).collect();
    let fit = Problem { observations: &kept, ..*problem }.solve();
    let enough = fit.rank == PARAMETERS && fit.freedom >= 1.0;
    enough.then(|| out.iter().map(|&at| norm_error(&fit.model, &problem.observations[at])).collect())
}

/// Norm of the calibrated reading minus what it has to be.
#[must_use]
pub fn norm_error(model: &Model, observation: &Observation) -> f64 {
    model.calibrate(&observation.raw).norm() - observation.norm
}

/// Root mean square; `None` of nothing.
#[must_use]
pub fn rms(errors: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = errors.fold((0_usize, 0.0), |(count, sum), error| (count + 1, sum + error * error));
    (count > 0).then(|| (sum / count as f64).sqrt())
}
