//! Places of stations with their uncertainty. Stations at one depth, as those of a cluster shot or of a roll test, are
//! one place of the hole: they share their mean direction, and errors that are drawn anew at each station come once.

use meerkat_mwd::survey::multi_station::{Decision, MultiStationReport};
use nalgebra::{Matrix3, Vector3};

use super::{
    path::{Direction, PathPoint, minimum_curvature},
    position_errors::{ModelStation, covariances, horizontal_ellipse},
    settings::RunSettings,
    surveyed::{AXIAL, SurveyedStation, start, turn},
    tool_codes::{Term, ToolCode},
};
use crate::failure::Failure;

/// Distance along the hole under which two stations are at one place, metres: the rounding of a depth.
const ONE_PLACE_M: f64 = 0.01;

/// Tool code of a run by what was done to it; names it at every station.
pub(super) fn tool_code(
    stations: &mut [SurveyedStation],
    settings: &RunSettings,
    report: Option<&MultiStationReport>,
    warnings: &mut Vec<String>,
) -> ToolCode {
    let multi_station = report.is_some_and(|report| report.azimuth == Decision::Corrected);
    let sag = settings.sag.is_some() || stations.iter().any(|station| station.sag_deg != 0.0);
    let wanted = ToolCode { field: settings.field_class(), sag, multi_station };
    let code = wanted.published();
    if code != wanted {
        warnings.push(format!(
            "there is no tool code {}: positions are as uncertain as with {}",
            wanted.name(false),
            code.name(false)
        ));
    }
    for station in stations {
        station.tool_code = code.name(station.corrected == AXIAL);
    }
    code
}

/// Terms of a tool code with the run's factors.
pub(super) fn terms(code: ToolCode, settings: &RunSettings) -> Result<Vec<Term>, Failure> {
    let mut terms = code.terms(&settings.errors);
    for (name, factor) in &settings.term_factors {
        let term = terms.iter_mut().find(|term| term.name == name).filter(|_| factor.is_finite() && *factor >= 0.0);
        let bad =
            || Failure::BadInput(format!("term_factors: {name} = {factor}: no term of the tool code, or no factor"));
        term.ok_or_else(bad)?.sigma *= factor;
    }
    Ok(terms)
}

/// Stations at one depth are one place.
fn one_place(one: &SurveyedStation, other: &SurveyedStation) -> bool {
    (one.md_m - other.md_m).abs() < ONE_PLACE_M
}

/// Gives the stations of each place the mean of their directions, without those that the others contradict.
pub(super) fn agree(stations: &mut [SurveyedStation]) {
    stations.chunk_by_mut(one_place).filter(|place| place.len() > 1).for_each(agree_here);
}

fn agree_here(stations: &mut [SurveyedStation]) {
    let all_doubted = stations.iter().all(|station| station.doubted);
    let counted = stations.iter().filter(|station| all_doubted || !station.doubted);
    let mean: Vector3<f64> = counted.map(|station| direction(station).tangent()).sum();
    let inclination_deg = libm::atan2(libm::hypot(mean.x, mean.y), mean.z).to_degrees();
    let azimuth_deg = libm::atan2(mean.y, mean.x).to_degrees();
    for station in stations {
        let turned = azimuth_deg - station.azimuth_deg;
        station.inclination_deg = inclination_deg;
        station.magnetic_azimuth_deg = turn(station.magnetic_azimuth_deg + turned);
        station.azimuth_deg = turn(azimuth_deg);
    }
}

fn direction(station: &SurveyedStation) -> Direction {
    Direction {
        md_m: station.md_m,
        inclination_rad: station.inclination_deg.to_radians(),
        azimuth_rad: station.azimuth_deg.to_radians(),
    }
}

/// Places of all stations with their covariances.
pub(super) fn place_all(
    stations: &mut [SurveyedStation],
    settings: &RunSettings,
    terms: &[Term],
    vertical_section_deg: f64,
) {
    let directions: Vec<Direction> =
        stations.chunk_by(one_place).filter_map(|place| Some(direction(place.first()?))).collect();
    let path = minimum_curvature(&directions, start(settings, directions.first()));
    let model: Vec<ModelStation> = (stations.chunk_by(one_place).zip(&directions).zip(&path))
        .filter_map(|((place, direction), point)| model_station(place, *direction, point))
        .collect();
    let covariances: Vec<Matrix3<f64>> = covariances(&model, terms);
    let places = stations.chunk_by_mut(one_place).zip(path.iter().zip(&covariances));
    for (station, (point, covariance)) in places.flat_map(|(place, at)| place.iter_mut().map(move |s| (s, at))) {
        let PathPoint { position_m, dogleg_rad_30m } = *point;
        station.position_m = position_m.into();
        station.dogleg_deg_30m = dogleg_rad_30m.to_degrees();
        station.vertical_section_m = point.vertical_section_m(vertical_section_deg.to_radians());
        station.covariance_m2 = covariance.transpose().into();
        let ([major, minor], azimuth) = horizontal_ellipse(covariance);
        station.ellipse = [major, minor, azimuth.to_degrees()];
    }
}

/// A place as the error model sees it.
fn model_station(place: &[SurveyedStation], direction: Direction, point: &PathPoint) -> Option<ModelStation> {
    let station = place.first()?;
    Some(ModelStation {
        direction,
        tvd_m: point.position_m.z,
        magnetic_azimuth_rad: station.magnetic_azimuth_deg.to_radians(),
        true_azimuth_rad: (station.magnetic_azimuth_deg + station.reference.declination_deg).to_radians(),
        field_ut: station.reference.field_ut,
        dip_rad: station.reference.dip_deg.to_radians(),
        gravity_m_s2: station.reference.gravity_m_s2,
        axial: place.iter().all(|station| station.corrected == AXIAL),
    })
}
