//! Calibration of one vector sensor, with everything that is reported of it.

use super::{
    held_out::{HeldOut, held_out, norm_error},
    model::Model,
    norm_fit::{Fit, Observation, Problem},
    verdict::{Bounds, Spread, Standard, Verdict, judge},
};
use testbed::score::root_mean_square;

/// The calibration of one vector sensor.
#[derive(Clone, Debug)]
pub struct SensorCalibration {
    /// The readings.
    pub observations: Vec<Observation>,
    /// The values on record before.
    pub record: Model,
    /// Prior deviations of the parameters from the record.
    pub prior: super::model::Parameters,
    /// The fit.
    pub fit: Fit,
    /// Required norm, in the sensor's unit.
    pub norm: f64,
    /// True if the norm was known, not fitted.
    pub norm_known: bool,
    /// Bounds on the error of calibrated vectors.
    pub bounds: Bounds,
    /// Spread of the readings' directions.
    pub spread: Spread,
    /// Error of the norm on readings not used for the fit.
    pub held_out: Option<HeldOut>,
    /// Decision about its new values: whether they go on record.
    pub verdict: Verdict,
}

impl SensorCalibration {
    /// Fits, checks and judges a sensor.
    #[must_use]
    pub fn of(problem: &Problem, norm: f64, on_record: bool, standard: Standard) -> Self {
        let fit = problem.solve();
        let bounds = Bounds::of(&fit, &problem.record, norm);
        let held_out = held_out(problem, &fit);
        let verdict = judge(problem, &fit, &bounds, held_out.as_ref(), on_record, standard);
        Self {
            observations: problem.observations.to_vec(),
            record: problem.record,
            prior: problem.prior,
            spread: Spread::of(&fit, problem.observations),
            fit,
            norm,
            norm_known: true,
            bounds,
            held_out,
            verdict,
        }
    }

    /// The model that goes on record: the new one, or the old one if that stays.
    #[must_use]
    pub const fn model(&self) -> Model {
        match self.verdict {
            Verdict::Calibrated | Verdict::Partly(_) => self.fit.model,
            Verdict::Kept(_) => self.record,
        }
    }

    /// Smallest and largest required norm, in the sensor's unit: they differ where the readings are from several
    /// places.
    #[must_use]
    pub fn norms(&self) -> [f64; 2] {
        let norms = || self.observations.iter().map(|observation| observation.norm);
        [norms().fold(f64::MAX, f64::min), norms().fold(f64::MIN, f64::max)]
    }

    /// Keeps the old values if the new ones are worse on `later` readings, which neither fit nor check have seen.
    pub(super) fn judge_on(&mut self, later: Option<&HeldOut>) {
        let is_no_worse = later.is_none_or(|check| check.after <= check.before);
        if self.is_new() && !is_no_worse {
            self.verdict = Verdict::Kept("it is worse on the part held out".into());
        }
    }

    /// Returns true if the record changes.
    #[must_use]
    pub const fn is_new(&self) -> bool {
        !matches!(self.verdict, Verdict::Kept(_))
    }

    /// Rms error of the norm over the readings used, in the sensor's unit: with the old values, with the new
    /// ones.
    #[must_use]
    pub fn before_after(&self) -> Option<(f64, f64)> {
        let used = || self.observations.iter().zip(&self.fit.used).filter(|(_, used)| **used).map(|(o, _)| o);
        let with = |model: Model| root_mean_square(used().map(move |observation| norm_error(&model, observation)));
        Some((with(self.record)?, with(self.fit.model)?))
    }

    /// Error of the norm of every reading, in the sensor's unit: with the old values, and with those that go on record.
    #[must_use]
    pub fn errors(&self) -> [Vec<f64>; 2] {
        [self.record, self.model()]
            .map(|model| self.observations.iter().map(|observation| norm_error(&model, observation)).collect())
    }

    /// Number of readings that the others contradict.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.fit.used.iter().filter(|used| !**used).count()
    }
}
