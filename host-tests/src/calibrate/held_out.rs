//! What a calibration is worth on readings that it has not seen.

use super::{
    model::{Model, PARAMETERS},
    norm_fit::{Fit, Observation, Problem},
    verdict::{Bounds, LARGEST_HARMLESS_RAD},
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

/// Fewer readings than this may be left out one at a time; leaving one out of thousands, next to others just like it, checks nothing.
const FEW: usize = 100;

/// Leaves out one of `parts` at a time, fits to the others and checks on it; where few readings are not enough by themselves, leaves one
/// reading out at a time. `part` tells to which part a reading belongs. Readings that the whole fit leaves out do not count.
#[must_use]
pub fn held_out(problem: &Problem, fit: &Fit, parts: usize, part: impl Fn(usize) -> usize) -> Option<HeldOut> {
    let used: Vec<usize> = (0..fit.used.len()).filter(|&at| fit.used[at]).collect();
    let few = used.len() <= FEW;
    let in_parts = || {
        let errors = (0..parts).map(|out| fitted_without(problem, &used, few, |at| part(at) == out));
        Some(errors.collect::<Option<Vec<_>>>()?.concat())
    };
    let each = || {
        let one = |&out: &usize| fitted_without(problem, &used, false, |at| at == out);
        let errors = used.iter().filter(|_| few).map(one).collect::<Option<Vec<_>>>()?;
        Some(errors.concat())
    };
    let how = if parts == 2 { "fitted to the other half" } else { "fitted to the other stretches" };
    let (how, errors) =
        in_parts().map(|errors| (how, errors)).or_else(|| each().map(|errors| ("fitted to all others", errors)))?;
    Some(HeldOut {
        how,
        count: used.len(),
        before: rms(used.iter().map(|&at| norm_error(&problem.record, &problem.observations[at])))?,
        after: rms(errors.iter().copied())?,
        noise: rms(used.iter().map(|&at| problem.observations[at].sigma))?,
        largest: errors.iter().fold(0.0, |largest: f64, error| largest.max(error.abs())),
    })
}

/// Errors of the norm at the readings `out`, with parameters fitted to the others; `None` if these do not determine all, or, asked to be
/// `harmless`, not every direction well enough.
fn fitted_without(problem: &Problem, used: &[usize], harmless: bool, out: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let kept: Vec<Observation> = used.iter().filter(|at| !out(**at)).map(|&at| problem.observations[at]).collect();
    let norm = kept.first()?.norm;
    let fit = Problem { observations: &kept, ..*problem }.solve();
    let enough = fit.rank == PARAMETERS
        && fit.freedom >= 1.0
        && (!harmless || Bounds::of(&fit, &problem.record, norm).direction_rad < LARGEST_HARMLESS_RAD);
    let checked = used.iter().filter(|at| out(**at)).map(|&at| norm_error(&fit.model, &problem.observations[at]));
    enough.then(|| checked.collect())
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
