//! Check of a calibration on readings that it was not fitted to.

use testbed::score::root_mean_square;

use super::{
    model::Model,
    norm_fit::{Fit, Observation, Problem},
};

/// Errors of the norm on readings held out, rms in the sensor's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Way in which they were held out.
    pub how: &'static str,
    /// Number of readings.
    pub count: usize,
    /// Error with the old values.
    pub before: f64,
    /// Error with values fitted to the other readings.
    pub after: f64,
    /// Error that the readings' own noise would leave with the true values.
    pub noise: f64,
    /// Largest error with values fitted to the other readings.
    pub largest: f64,
}

/// Stretches that readings are cut into if neighbours are alike: a single reading left out would be checked
/// by its like.
const STRETCHES: usize = 10;

/// Leaves out one part at a time, fits to the rest and checks on that part. Rests are left out one by one:
/// they have nothing in common, and half of two dozen would hardly exceed the number of parameters. Readings
/// that the whole fit excludes do not count. `None` if a part is needed to determine as much as the whole does.
#[must_use]
pub fn held_out(problem: &Problem, fit: &Fit) -> Option<HeldOut> {
    if fit.rank == 0 {
        return None;
    }
    let used: Vec<usize> = (0..fit.used.len()).filter(|&at| fit.used[at]).collect();
    let (parts, how) = if problem.correlated {
        (STRETCHES.min(used.len()), "fitted to the other stretches")
    } else {
        (used.len(), "fitted to all others")
    };
    let errors = (0..parts).map(|part| {
        let [from, to] = [part, part + 1].map(|part| part * used.len() / parts);
        fitted_without(problem, fit.rank, &used[from..to], &[&used[..from], &used[to..]].concat())
    });
    let errors = errors.collect::<Option<Vec<_>>>()?.concat();
    Some(HeldOut {
        how,
        count: used.len(),
        before: root_mean_square(used.iter().map(|&at| norm_error(&problem.record, &problem.observations[at])))?,
        after: root_mean_square(errors.iter().copied())?,
        noise: root_mean_square(used.iter().map(|&at| problem.observations[at].sigma))?,
        largest: errors.iter().fold(0.0, |largest: f64, error| largest.max(error.abs())),
    })
}

/// Errors of the norm at the readings `out`, with parameters fitted to `others`; `None` if those determine fewer than
/// `rank` directions of the parameters.
fn fitted_without(problem: &Problem, rank: usize, out: &[usize], others: &[usize]) -> Option<Vec<f64>> {
    let kept: Vec<Observation> = others.iter().map(|&at| problem.observations[at]).collect();
    let fit = Problem { observations: &kept, ..*problem }.solve();
    let enough = fit.rank >= rank && fit.freedom >= 1.0;
    enough.then(|| out.iter().map(|&at| norm_error(&fit.model, &problem.observations[at])).collect())
}

/// Norm of the calibrated reading minus its required value.
#[must_use]
pub fn norm_error(model: &Model, observation: &Observation) -> f64 {
    model.calibrate(&observation.raw).norm() - observation.norm
}
