//! Which of a station's angles are believed: as measured, or as one of the corrections has them.

use meerkat_mwd::{
    config::SurveyErrors,
    survey::{
        AxialCorrection, Uncertain,
        multi_station::{CorrectedStation, Decision, MultiStationReport},
    },
};
use nalgebra::Vector3;

use super::settings::{Correction, RunSettings};

/// Word for a station that has the short-collar correction.
pub const AXIAL: &str = "axial";

/// An angle, radians, with a standard deviation where one is known.
pub struct Angle {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub sigma: Option<f64>,
}

impl From<Uncertain> for Angle {
    fn from(x: Uncertain) -> Self {
        Self { value: x.value.into(), sigma: Some(x.sigma.into()) }
    }
}

/// Inclination and azimuth that are believed, and how the azimuth was corrected.
pub fn chosen(
    settings: &RunSettings,
    measured: [f64; 2],
    corrected: Option<CorrectedStation>,
    axial: Option<AxialCorrection>,
    report: Option<&MultiStationReport>,
) -> (Angle, Angle, &'static str) {
    let plain = |value| Angle { value, sigma: None };
    match (corrected, axial) {
        (Some(corrected), _) => {
            let how = match report.map(|report| report.azimuth) {
                Some(Decision::Corrected) => "multi-station",
                _ => "no",
            };
            (corrected.inclination_rad.into(), corrected.magnetic_azimuth_rad.into(), how)
        }
        (None, Some(axial)) if settings.correction == Correction::Axial && !axial.no_go => {
            (plain(measured[0]), axial.magnetic_azimuth_rad.into(), AXIAL)
        }
        (None, Some(axial)) => (plain(measured[0]), axial.measured_azimuth_rad.into(), "no"),
        (None, None) => (plain(measured[0]), plain(measured[1]), "no"),
    }
}

impl Angle {
    /// The angle with what a survey of the tool states of itself, `own`, beyond what the run's settings say of the
    /// measured angle: noise, and what was taken out of the readings, are in no correction.
    pub fn with_own(self, own: Option<f64>, by_settings: Option<f64>) -> Self {
        let Some(own) = own else { return self };
        let before = self.sigma.or(by_settings).unwrap_or(0.0);
        let known = by_settings.unwrap_or(before);
        let more = (own * own - known * known).max(0.0);
        Self { sigma: Some(libm::sqrt(before * before + more)), ..self }
    }
}

/// Standard deviation of a measured inclination, radians, by bias and scale of each axis of the accelerometer.
pub fn inclination_sigma(force_m_s2: &Vector3<f64>, errors: &SurveyErrors) -> f64 {
    let gravity = force_m_s2.norm();
    let down = force_m_s2 / -gravity;
    let across = (Vector3::z() - down * down.z).try_normalize(1e-6).unwrap_or(Vector3::x());
    let [bias, scale] = [errors.accel_bias_m_s2, errors.accel_scale].map(f64::from);
    let by_axis = force_m_s2.map(|x| bias * bias + scale * scale * x * x);
    libm::sqrt(across.component_mul(&across).dot(&by_axis)) / gravity
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_survey_that_is_less_certain_than_the_settings_say_stays_so_after_a_correction() {
        let with = |sigma, own, by_settings| Angle { value: 1.0, sigma }.with_own(own, by_settings).sigma;
        assert_eq!(with(None, None, Some(3.0)), None);
        assert_eq!(with(None, Some(5.0), None), Some(5.0));
        // As measured the larger one counts.
        assert_eq!([2.0, 5.0].map(|own| with(Some(3.0), Some(own), Some(3.0)).unwrap()), [3.0, 5.0]);
        // A correction takes out what the settings know of, not the rest: 5^2 - 3^2 = 4^2.
        assert!((with(Some(1.0), Some(5.0), Some(3.0)).unwrap() - libm::sqrt(17.0)).abs() < 1e-12);
    }

    #[test]
    fn the_inclinations_sigma_is_the_accelerometers_bias_over_gravity() {
        let errors = SurveyErrors { accel_bias_m_s2: 0.004, accel_scale: 0.0, ..SurveyErrors::default() };
        for force in [Vector3::new(0.0, 0.0, -9.8), Vector3::new(4.0, -3.0, -8.0)] {
            let sigma = inclination_sigma(&force, &errors);
            assert!((sigma - f64::from(0.004_f32) / force.norm()).abs() < 1e-12, "{sigma}");
        }
    }
}
