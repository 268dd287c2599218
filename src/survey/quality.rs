//! Quality of a survey: |G|, |B| and dip against their references.

use super::{Survey, Uncertain};
use crate::config::{Earth, SurveyConfig};

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

/// Quantity that a check compares with its reference.
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
    /// Check with the largest ratio to its limit: the reason of a grade other than good.
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
        let check = |checked, measured: Option<Uncertain>, reference: f32, sigma: f32, fixed: f32| {
            let limit = match measured {
                Some(measured) if limits.propagated => {
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
        let part = |check: &Check| check.difference.map_or(f32::INFINITY, |difference| difference.abs() / check.limit);
        let mut reason = gravity;
        for other in [field, dip].into_iter().flatten() {
            if part(&other) > part(&reason) {
                reason = other;
            }
        }
        Self { grade: reason.grade, reason, gravity, field, dip }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::{SurveyKind, ToolfaceKind};

    fn survey(gravity: f32, field: Option<f32>, dip_deg: f32) -> Survey {
        let uncertain = |value, sigma| Uncertain { value, sigma };
        Survey {
            kind: SurveyKind::Stationary,
            t_start_us: 0,
            t_end_us: 1,
            inclination_rad: Uncertain::default(),
            magnetic_azimuth_rad: None,
            true_azimuth_rad: None,
            grid_azimuth_rad: None,
            gravity_toolface_rad: None,
            magnetic_toolface_rad: None,
            toolface_kind: ToolfaceKind::Gravity,
            gravity_m_s2: Some(uncertain(gravity, 0.006)),
            field_ut: field.map(|x| uncertain(x, 0.12)),
            dip_rad: field.map(|_| uncertain(dip_deg.to_radians(), 0.2_f32.to_radians())),
            temperature_c: None,
            rotating: false,
        }
    }

    const fn earth() -> Earth {
        Earth {
            gravity_m_s2: 9.8,
            magnetic_field_ut: Some(50.0),
            dip_rad: Some(70.0_f32.to_radians()),
            declination_rad: None,
            latitude_rad: None,
        }
    }

    #[test]
    fn the_grade_and_its_reason_follow_the_check_that_is_furthest_off() {
        let config = SurveyConfig::default();
        let judged = |gravity, field, dip| {
            let quality = Quality::of(&survey(gravity, field, dip), &earth(), &config);
            (quality.grade, quality.reason.checked, quality.reason.difference)
        };
        assert_eq!(judged(9.80, Some(50.25), 70.1).0, Grade::Good);
        let (grade, checked, difference) = judged(9.80, Some(50.4), 70.1);
        assert_eq!((grade, checked), (Grade::Doubtful, Checked::Field));
        assert!((difference.unwrap() - 0.4).abs() < 1e-5);
        assert_eq!(judged(9.80, Some(49.5), 70.1).0, Grade::Bad);
        let (grade, checked, difference) = judged(9.80, Some(50.4), 69.6);
        assert_eq!((grade, checked), (Grade::Bad, Checked::Dip));
        assert!((difference.unwrap().to_degrees() + 0.4).abs() < 1e-3);
        assert_eq!(judged(9.83, Some(50.0), 70.0).1, Checked::Gravity);
        assert_eq!(judged(9.80, None, 70.0).0, Grade::Bad);
    }

    #[test]
    fn without_a_reference_a_check_is_not_made() {
        let earth = Earth { magnetic_field_ut: None, dip_rad: None, ..earth() };
        let quality = Quality::of(&survey(9.8, Some(80.0), 10.0), &earth, &SurveyConfig::default());
        assert_eq!((quality.grade, quality.field, quality.dip), (Grade::Good, None, None));
    }

    #[test]
    fn propagated_limits_are_deviations_of_measurement_and_reference() {
        let mut config = SurveyConfig::default();
        config.limits.propagated = true;
        let quality = Quality::of(&survey(9.81, Some(50.4), 70.0), &earth(), &config);
        assert!((quality.field.unwrap().limit - 2.0 * libm::hypotf(0.12, 0.13)).abs() < 1e-6);
        assert!((quality.gravity.limit - 0.012).abs() < 1e-6);
        assert!((quality.dip.unwrap().limit.to_degrees() - 2.0 * libm::hypotf(0.2, 0.2)).abs() < 1e-5);
        assert_eq!(quality.reason.checked, Checked::Field);
        assert_eq!(quality.grade, Grade::Doubtful);
    }
}
