//! What a calibration is worth on readings that it has not seen.

use super::norm_fit::{Fit, Observation, Problem};
use super::model::{Model, PARAMETERS};

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
    /// The largest error, with values fitted to the others.
    pub largest: f64,
}

/// Fits to each half and checks on the other; where a half does not determine all parameters, leaves one out at a time. `half` tells to
/// which half a reading belongs. Readings that the whole fit leaves out do not count.
#[must_use]
pub fn held_out(problem: &Problem, fit: &Fit, half: impl Fn(usize) -> bool) -> Option<HeldOut> {
    let used: Vec<usize> = (0..fit.used.len()).filter(|&at| fit.used[at]).collect();
    let halves = || {
        let errors = [true, false].map(|side| fitted_without(problem, &used, |at| half(at) == side));
        let [first, second] = errors;
        Some([first?, second?].concat())
    };
    // Leaving one out of thousands, next to others just like it, checks nothing.
    let each = || {
        let one = |&out: &usize| fitted_without(problem, &used, |at| at == out);
        let few = used.len() <= 100;
        few.then(|| used.iter().map(one).collect::<Option<Vec<_>>>()).flatten().map(|errors| errors.concat())
    };
    let (how, errors) = halves().map(|errors| ("fitted to the other half", errors)).or_else(|| {
        each().map(|errors| ("fitted to all others", errors))
    })?;
    Some(HeldOut {
        how,
        count: used.len(),
        before: rms(used.iter().map(|&at| norm_error(&problem.record, &problem.observations[at])))?,
        after: rms(errors.iter().copied())?,
        largest: errors.iter().fold(0.0, |largest: f64, error| largest.max(error.abs())),
    })
}

/// Errors of the norm at the readings `out`, with parameters fitted to the others; `None` if these do not determine all.
fn fitted_without(problem: &Problem, used: &[usize], out: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
    let kept: Vec<Observation> = used.iter().filter(|at| !out(**at)).map(|&at| problem.observations[at]).collect();
    let fit = Problem { observations: &kept, ..*problem }.solve();
    let checked = used.iter().filter(|at| out(**at)).map(|&at| norm_error(&fit.model, &problem.observations[at]));
    (fit.rank == PARAMETERS).then(|| checked.collect())
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
