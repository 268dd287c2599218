//! Which of a station's angles are believed: as measured, or as one of the corrections has them.

use meerkat_mwd::survey::{
    AxialCorrection, Uncertain,
    multi_station::{CorrectedStation, Decision, MultiStationReport},
};

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
