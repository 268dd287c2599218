//! From stations to corrected directions, positions and their uncertainty.

use libm::remainder;
use meerkat_mwd::survey::{
    AxialCorrection,
    multi_station::{Decision, MultiStationReport, Station, StationReference},
};
use nalgebra::Vector3;

use super::{
    analysis::{Analysis, analysed},
    chosen::{AXIAL, chosen, inclination_sigma},
    far_off::{far_off, off_at},
    measured::Measured,
    path::{Direction, minimum_curvature},
    placed::{Placed, Shot, contradictions, placed},
    position_errors::horizontal_ellipse,
    reference::{Provenance, Reference, ReferenceAt},
    run::{SurveyedRun, SurveyedStation},
    run_code::{terms, tool_code},
    settings::{Correction, RunSettings},
    stations_csv::ReadStation,
    term_weights::ModelStation,
};
use testbed::failure::Failure;

/// Smallest fall of the depth from one station to the next that is an error and not the rounding of one depth, metres.
const FALL_M: f64 = 0.01;

/// A station between reading and path.
struct Pending {
    read: ReadStation,
    md_m: f64,
    reference: ReferenceAt,
    station: Option<Station>,
}

/// Works out a run.
///
/// # Errors
/// A station has no depth, or no usable gravity and field; the reference does not reach it.
pub fn surveyed(read: &[ReadStation], settings: &RunSettings, reference: &Reference) -> Result<SurveyedRun, Failure> {
    let sag = sag_of(read, settings)?;
    let pending = pending(read, settings, reference)?;
    let mut warnings = reference.warnings.clone();
    if let (None, Some(first)) = (settings.start_m, pending.first())
        && first.md_m > 0.0
    {
        warnings.push(format!("no start_m: the hole above {:.1} m is taken as vertical", first.md_m));
    }
    if let Some(first) = pending.first().filter(|first| first.md_m > 0.0) {
        warnings.push(format!(
            "uncertainties of positions count from the first station, at {:.1} m: what the hole above it adds is not in them",
            first.md_m
        ));
    }
    let six_axis: Vec<Option<Station>> = pending.iter().map(|pending| pending.station).collect();
    let (report, places) = analysed(&six_axis, settings, &mut warnings);
    let convergence_deg = reference.convergence_deg()?;
    let mut stations: Vec<SurveyedStation> = pending
        .iter()
        .enumerate()
        .map(|(k, pending)| {
            let place = places.iter().position(|&place| place == k);
            let doubted = report.as_ref().zip(place).is_some_and(|(report, place)| report.left_out >> place & 1 == 1);
            directed(pending, settings, reference.provenance(), report.as_ref(), convergence_deg, doubted)
        })
        .collect();
    let multi_station = report.as_ref().is_some_and(|report| report.azimuth == Decision::Corrected);
    let (code, without) = tool_code(settings, sag.is_some(), multi_station);
    warnings.extend(without);
    let off: Vec<(f64, [f64; 3])> =
        stations.iter().filter_map(|station| Some((station.md_m, station.off_reference?))).collect();
    warnings.extend(far_off(&off.iter().map(|(_, off)| *off).collect::<Vec<_>>()));
    warnings.extend(off_at(&off));
    if settings.correction == Correction::Axial {
        warnings.extend(without_axial(&stations));
    }
    for station in &mut stations {
        station.tool_code = code.name(station.corrected == AXIAL);
    }
    let shots: Vec<Shot> = stations.iter().map(shot).collect();
    warnings.extend(contradictions(&shots));
    let start = start(settings, shots.first().map(|first| &first.station.direction));
    let places = placed(&shots, start, &terms(code, settings)?);
    let last_azimuth = places.last().map_or(0.0, |last| turn(last.direction.azimuth_rad.to_degrees()));
    let vertical_section_deg = settings.vertical_section_deg.unwrap_or(last_azimuth);
    for (station, place) in stations.iter_mut().zip(&places) {
        put(station, place, vertical_section_deg);
    }
    let mut tool_codes: Vec<String> = stations.iter().map(|station| station.tool_code.clone()).collect();
    tool_codes.sort();
    tool_codes.dedup();
    Ok(SurveyedRun {
        well: settings.well.clone(),
        correction: settings.correction,
        sag,
        provenance: reference.provenance().clone(),
        convergence_deg,
        vertical_section_deg,
        tool_codes,
        analysis: report.as_ref().map(Analysis::of),
        warnings,
        stations,
    })
}

/// Number of stations without a short-collar correction although it was asked for, and the reason.
fn without_axial(stations: &[SurveyedStation]) -> Vec<String> {
    let without = |with_readings: bool| {
        let is_one = |s: &&SurveyedStation| s.axial_no_go.is_none() && s.readings.is_some() == with_readings;
        stations.iter().filter(is_one).count()
    };
    let why = [
        (without(true), "no field along the axis within 20 microtesla of the measured one agrees with the reference"),
        (without(false), "they have no gravity and field"),
    ];
    let told = |(count, why)| format!("no short-collar correction at {count} stations: {why}");
    why.into_iter().filter(|(count, _)| *count > 0).map(told).collect()
}

/// Source of the sag, in words; `None` where none is to be added.
fn sag_of(read: &[ReadStation], settings: &RunSettings) -> Result<Option<String>, Failure> {
    match (read.iter().any(|station| station.sag_deg.is_some()), settings.sag) {
        (true, Some(_)) => Err(Failure::BadInput(
            "sag is given twice: leave out the stations' column sag_deg or the settings' table [sag]".to_owned(),
        )),
        (true, None) => Ok(Some("stated for each station (column sag_deg)".to_owned())),
        (false, sag) => Ok(sag.map(|sag| sag.to_string())),
    }
}

/// Gives each station its depth and its reference at its true vertical depth, by a path of the measured angles.
fn pending(read: &[ReadStation], settings: &RunSettings, reference: &Reference) -> Result<Vec<Pending>, Failure> {
    let mut directions = Vec::new();
    for (k, station) in read.iter().enumerate() {
        let md_m = station.md_m.ok_or_else(|| Failure::BadInput(format!("station {}: no depth", k + 1)))?;
        if directions.last().is_some_and(|last: &Direction| md_m < last.md_m - FALL_M) {
            return Err(Failure::BadInput(format!("station {} at {md_m:.2} m: depth falls", k + 1)));
        }
        let [inclination_rad, azimuth_rad] = station.measured.angles().ok_or_else(|| {
            Failure::BadInput(format!("station {} at {md_m:.2} m: {}", k + 1, station.measured.why_unusable()))
        })?;
        directions.push(Direction { md_m, inclination_rad, azimuth_rad });
    }
    let path = minimum_curvature(&directions, start(settings, directions.first()));
    let with_reference = read.iter().zip(&directions).zip(&path).map(|((read, direction), point)| {
        let reference = reference.at(point.position_m.z)?;
        let station = match read.measured {
            Measured::SixAxis { force_m_s2, field_ut } => Some(Station {
                depth_m: direction.md_m as f32,
                force_m_s2: force_m_s2.map(|x| x as f32).into(),
                field_ut: field_ut.map(|x| x as f32).into(),
                reference: StationReference {
                    gravity_m_s2: reference.gravity_m_s2 as f32,
                    field_ut: reference.field_ut as f32,
                    dip_rad: reference.dip_deg.to_radians() as f32,
                },
            }),
            Measured::Angles { .. } => None,
        };
        Ok(Pending { read: *read, md_m: direction.md_m, reference, station })
    });
    with_reference.collect()
}

/// Position of the first station.
fn start(settings: &RunSettings, first: Option<&Direction>) -> Vector3<f64> {
    let below = [0.0, 0.0, first.map_or(0.0, |first| first.md_m)];
    Vector3::from(settings.start_m.unwrap_or(below))
}

/// Directions of a station; its place is left at zero.
fn directed(
    pending: &Pending,
    settings: &RunSettings,
    provenance: &Provenance,
    report: Option<&MultiStationReport>,
    convergence_deg: Option<f64>,
    doubted: bool,
) -> SurveyedStation {
    let reference = pending.reference;
    let measured = pending.read.measured.angles().unwrap_or_default();
    let corrected = pending.station.and_then(|station| report?.corrected(&station));
    let axial = pending.station.and_then(|station| AxialCorrection::of(&station, &settings.errors));
    let readings = match pending.read.measured {
        Measured::SixAxis { force_m_s2, field_ut } => Some((force_m_s2, field_ut)),
        Measured::Angles { .. } => None,
    };
    let (inclination, azimuth, how) = chosen(settings, measured, corrected, axial, report);
    let own = |k: usize| pending.read.sigma_rad.map(|sigma| sigma[k]);
    let inclination =
        inclination.with_own(own(0), readings.map(|(force, _)| inclination_sigma(&force, &settings.errors)));
    let azimuth = azimuth.with_own(own(1), axial.map(|axial| axial.measured_azimuth_rad.sigma.into()));
    let modelled = || settings.sag.map(|sag| sag.correction_rad(inclination.value).to_degrees());
    let sag_deg = pending.read.sag_deg.or_else(modelled).unwrap_or(0.0);
    let declination = libm::hypot(
        f64::from(settings.errors.declination_rad),
        f64::from(settings.errors.declination_rad_ut)
            / (reference.field_ut * libm::cos(reference.dip_deg.to_radians())),
    );
    let azimuth_deg = azimuth.value.to_degrees() + reference.declination_deg - convergence_deg.unwrap_or(0.0);
    SurveyedStation {
        md_m: pending.md_m,
        reference,
        reference_model: provenance.model.clone(),
        reference_date: provenance.date.clone(),
        convergence_deg,
        readings: readings.map(|(force, field)| [force.into(), field.into()]),
        measured_deg: [measured[0].to_degrees(), turn(measured[1].to_degrees())],
        inclination_deg: inclination.value.to_degrees() + sag_deg,
        sigma_inclination_deg: inclination.sigma.map(f64::to_degrees),
        magnetic_azimuth_deg: turn(azimuth.value.to_degrees()),
        sigma_magnetic_azimuth_deg: azimuth.sigma.map(f64::to_degrees),
        azimuth_deg: turn(azimuth_deg),
        sigma_azimuth_deg: azimuth.sigma.map(|sigma| libm::hypot(sigma, declination).to_degrees()),
        // Highside: gravity's part across the axis points away from it.
        gravity_toolface_deg: readings.map(|(force, _)| turn(libm::atan2(-force.y, force.x).to_degrees())),
        off_reference: readings.map(|(force, field)| {
            let dip = libm::asin((-force.dot(&field) / (force.norm() * field.norm())).clamp(-1.0, 1.0));
            [
                force.norm() - reference.gravity_m_s2,
                field.norm() - reference.field_ut,
                dip.to_degrees() - reference.dip_deg,
            ]
        }),
        sag_deg,
        corrected: how,
        tool_code: String::new(),
        axial_interference_ut: axial
            .map(|axial| [axial.interference_ut.value, axial.interference_ut.sigma].map(f64::from)),
        axial_no_go: axial.map(|axial| axial.no_go),
        doubted,
        position_m: [0.0; 3],
        dogleg_deg_30m: 0.0,
        vertical_section_m: 0.0,
        covariance_m2: [[0.0; 3]; 3],
        ellipse: [0.0; 3],
    }
}

/// A station as its place and the error model need it.
fn shot(station: &SurveyedStation) -> Shot {
    let direction = Direction {
        md_m: station.md_m,
        inclination_rad: station.inclination_deg.to_radians(),
        azimuth_rad: station.azimuth_deg.to_radians(),
    };
    let reference = station.reference;
    let station_here = ModelStation {
        direction,
        tvd_m: 0.0,
        magnetic_azimuth_rad: station.magnetic_azimuth_deg.to_radians(),
        true_azimuth_rad: (station.magnetic_azimuth_deg + reference.declination_deg).to_radians(),
        field_ut: reference.field_ut,
        dip_rad: reference.dip_deg.to_radians(),
        gravity_m_s2: reference.gravity_m_s2,
        axial: station.corrected == AXIAL,
    };
    Shot { station: station_here, doubted: station.doubted }
}

/// Puts a station at its place, with the direction that the hole has there.
fn put(station: &mut SurveyedStation, place: &Placed, vertical_section_deg: f64) {
    let azimuth_deg = place.direction.azimuth_rad.to_degrees();
    station.inclination_deg = place.direction.inclination_rad.to_degrees();
    station.magnetic_azimuth_deg = turn(station.magnetic_azimuth_deg + azimuth_deg - station.azimuth_deg);
    station.azimuth_deg = turn(azimuth_deg);
    station.position_m = place.point.position_m.into();
    station.dogleg_deg_30m = place.point.dogleg_rad_30m.to_degrees();
    station.vertical_section_m = place.point.vertical_section_m(vertical_section_deg.to_radians());
    station.covariance_m2 = place.covariance.transpose().into();
    let ([major, minor], azimuth) = horizontal_ellipse(&place.covariance);
    station.ellipse = [major, minor, azimuth.to_degrees()];
}

/// Degrees within 0 to 360.
fn turn(degrees: f64) -> f64 {
    let within = remainder(degrees, 360.0);
    if within < 0.0 { within + 360.0 } else { within }
}
