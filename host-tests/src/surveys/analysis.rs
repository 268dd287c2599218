//! The multi-station analysis of a run: of which stations, and its result in words.

use meerkat_mwd::survey::multi_station::{
    Decision, LEAST_STATIONS, MAX_STATIONS, MultiStation, MultiStationReport, Station,
};
use serde::Serialize;

use super::settings::{Correction, RunSettings};

/// A multi-station analysis in numbers and words.
#[derive(Debug, Serialize)]
pub struct Analysis {
    /// Number of stations that it rests on.
    pub counted: usize,
    /// Decision about the azimuths.
    pub azimuth: String,
    /// Decision about the inclinations.
    pub inclination: String,
    /// Residuals' variance over the stated noise's.
    pub noise_ratio: f32,
    /// Rms of the residuals in units of the noise: uncorrected, and of stations as the others predict them.
    pub residual: [f32; 2],
    /// True if the drill string's field grew over the run.
    pub axial_field_grows: bool,
    /// Common errors: name, value, sigma, sigma before, and whether the stations determine it.
    pub estimates: Vec<(&'static str, f32, f32, f32, bool)>,
}

impl Analysis {
    /// That of a report.
    #[must_use]
    pub(super) fn of(report: &MultiStationReport) -> Self {
        let decision = |decision| match decision {
            Decision::Corrected => "corrected".to_owned(),
            Decision::Refused(reason) => format!("as measured: {}", reason.told()),
            _ => "as measured".to_owned(),
        };
        Self {
            counted: report.counted,
            azimuth: decision(report.azimuth),
            inclination: decision(report.inclination),
            noise_ratio: report.noise_ratio,
            residual: [report.residual_uncorrected, report.residual_left_out],
            axial_field_grows: report.axial_field_grows(),
            estimates: report
                .estimates()
                .iter()
                .map(|e| (e.parameter.name(), e.estimate.value, e.estimate.sigma, e.prior_sigma, e.observable))
                .collect(),
        }
    }
}

/// Analyses the stations of a run that have gravity and field together: all, or of more than the analysis holds as
/// many, evenly spread. Returns with the report which stations those are.
pub(super) fn analysed(
    stations: &[Option<Station>],
    settings: &RunSettings,
    warnings: &mut Vec<String>,
) -> (Option<MultiStationReport>, Vec<usize>) {
    let six: Vec<(usize, Station)> =
        stations.iter().enumerate().filter_map(|(k, station)| Some((k, (*station)?))).collect();
    let count = six.len().min(MAX_STATIONS);
    if count < six.len() {
        warnings.push(format!(
            "the analysis holds {MAX_STATIONS} stations: it rests on every {:.1}th",
            six.len() as f64 / count as f64
        ));
    }
    let mut all = MultiStation::new();
    let mut places = Vec::new();
    for k in 0..count {
        if let Some((place, station)) = six.get(k * six.len() / count)
            && all.push(*station).is_ok()
        {
            places.push(*place);
        }
    }
    if settings.correction != Correction::MultiStation {
        return (None, places);
    }
    let report = all.analyse(&settings.errors, &settings.multi_station);
    // Angles without readings, and no word of a correction: nothing to analyse, and nothing asked for.
    if report.is_none() && !six.is_empty() {
        warnings.push(not_analysed(places.len()));
    }
    (report, places)
}

/// Why there is no multi-station analysis although one was asked for.
fn not_analysed(usable: usize) -> String {
    let why = if usable < LEAST_STATIONS {
        format!("{usable} stations have gravity and field, and it needs {LEAST_STATIONS}")
    } else {
        "gravity and field are too far from the reference, or a stated error is 0".to_owned()
    };
    format!("no multi-station analysis, directions are as measured: {why}")
}
