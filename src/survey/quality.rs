//! Quality of a survey: |G|, |B| and dip against their references, and how the sensors are mounted.

use super::{Survey, SurveyKind, Uncertain};
use crate::{
    config::{Earth, SurveyConfig},
    sample::TurnFlags,
};

/// Grade of a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Grade {
    /// Every possible check is within its limit.
    Good,
    /// A check is beyond its limit.
    Doubtful,
    /// A check is far beyond its limit, or a measurement that the check needs is missing.
    Bad,
}

/// Subject of a check: a quantity against its reference, or the mounting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Checked {
    /// |G|, m/s^2.
    Gravity,
    /// |B|, microtesla.
    Field,
    /// Dip, radians.
    Dip,
    /// Agreement of the sensors on a turn, see [`MountingCheck`](crate::sensors::MountingCheck). It has no number.
    Mounting,
}

/// One comparison, in the unit of the [`Checked`] quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Check {
    /// Quantity that is compared.
    pub checked: Checked,
    /// Measured less reference; `None` if not measured.
    pub difference: Option<f32>,
    /// Largest difference of a good survey.
    pub limit: f32,
    /// Grade by this check alone.
    pub grade: Grade,
}

/// Comparisons of one survey.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quality {
    /// Worst grade of the checks.
    pub grade: Grade,
    /// Reason of a grade other than good: the mounting, or the check with the largest ratio to its limit.
    pub reason: Check,
    /// Total gravity.
    pub gravity: Check,
    /// Total field; `None` without a configured reference.
    pub field: Option<Check>,
    /// Dip; `None` without a configured reference.
    pub dip: Option<Check>,
}

impl Quality {
    /// Compares a survey with the references of `earth`, by the limits of `config`.
    #[must_use]
    pub fn of(survey: &Survey, earth: &Earth, config: &SurveyConfig) -> Self {
        let (limits, errors) = (&config.limits, &config.errors);
        let is_propagated = limits.propagated || survey.kind == SurveyKind::Rotating;
        let check = |checked, measured: Option<Uncertain>, reference: f32, sigma: f32, fixed: f32| {
            let limit = match measured {
                Some(measured) if is_propagated => {
                    limits.deviations * libm::sqrtf(measured.sigma * measured.sigma + sigma * sigma)
                }
                _ => fixed,
            };
            let difference = measured.map(|measured| measured.value - reference);
            let grade = match difference {
                Some(difference) if difference.abs() <= limit => Grade::Good,
                Some(difference) if difference.abs() <= limits.bad_over_limit * limit => Grade::Doubtful,
                _ => Grade::Bad,
            };
            Check { checked, difference, limit, grade }
        };
        let gravity = check(Checked::Gravity, survey.gravity_m_s2, earth.gravity_m_s2, 0.0, limits.gravity_m_s2);
        let field = earth
            .magnetic_field_ut
            .map(|reference| check(Checked::Field, survey.field_ut, reference, errors.total_field_ut, limits.field_ut));
        let dip = earth
            .dip_rad
            .map(|reference| check(Checked::Dip, survey.dip_rad, reference, errors.dip_rad, limits.dip_rad));
        let part = |check: &Check| match check.difference {
            // A NaN is as far from the reference as can be.
            Some(difference) if !difference.is_nan() => difference.abs() / check.limit,
            _ => f32::INFINITY,
        };
        let mut reason = gravity;
        for other in [field, dip].into_iter().flatten() {
            if part(&other) > part(&reason) {
                reason = other;
            }
        }
        Self { grade: reason.grade, reason, gravity, field, dip }
    }

    /// Makes it bad if the sensors do not agree on these turns.
    pub(super) fn mounted(&mut self, wrong: TurnFlags) {
        if !wrong.is_empty() {
            self.reason = Check { checked: Checked::Mounting, difference: None, limit: 0.0, grade: Grade::Bad };
            self.grade = Grade::Bad;
        }
    }
}

#[cfg(test)]
mod tests;
