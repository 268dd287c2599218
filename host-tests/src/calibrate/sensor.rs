//! One sensor's calibration with all that is told of it.

use super::{
    held_out::{HeldOut, held_out, norm_error, rms},
    model::Model,
    norm_fit::{Fit, Observation, Problem},
    verdict::{Bounds, Spread, Standard, Verdict, judge},
};

/// The calibration of one vector sensor.
#[derive(Clone, Debug)]
pub struct SensorCalibration {
    /// The readings.
    pub observations: Vec<Observation>,
    /// The values that were on record.
    pub record: Model,
    /// How far these were trusted.
    pub prior: super::model::Parameters,
    /// The fit.
    pub fit: Fit,
    /// The norm that the readings have to have, in the sensor's unit.
    pub norm: f64,
    /// Whether that was known, and not fitted.
    pub norm_known: bool,
    /// How far off calibrated vectors can be.
    pub bounds: Bounds,
    /// How the readings' directions are spread.
    pub spread: Spread,
    /// Error of the norm on readings not used for the fit.
    pub held_out: Option<HeldOut>,
    /// Whether it goes on record.
    pub verdict: Verdict,
}

impl SensorCalibration {
    /// Fits, checks and judges.
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

    /// The model that goes on record: the new one, or the old one where it stays.
    #[must_use]
    pub const fn model(&self) -> Model {
        match self.verdict {
            Verdict::Calibrated | Verdict::Partly(_) => self.fit.model,
            Verdict::Kept(_) => self.record,
        }
    }

    /// Whether the record changes.
    #[must_use]
    pub const fn is_new(&self) -> bool {
        !matches!(self.verdict, Verdict::Kept(_))
    }

    /// Root mean square error of the norm over the readings used, in the sensor's unit: old values, new values.
    #[must_use]
    pub fn before_after(&self) -> Option<(f64, f64)> {
        let used = || self.observations.iter().zip(&self.fit.used).filter(|(_, used)| **used).map(|(o, _)| o);
        let with = |model: Model| rms(used().map(move |observation| norm_error(&model, observation)));
        Some((with(self.record)?, with(self.fit.model)?))
    }

    /// Readings that the others contradict.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.fit.used.iter().filter(|used| !**used).count()
    }
}
