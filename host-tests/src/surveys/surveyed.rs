//! From stations to corrected directions, positions and their uncertainty.

use libm::remainder;
use meerkat_mwd::survey::{
    AxialCorrection,
    multi_station::{
        Decision, LEAST_STATIONS, MAX_STATIONS, MultiStation, MultiStationReport, Station, StationReference,
    },
};
use nalgebra::Vector3;
use serde::Serialize;

use super::{
    chosen::{AXIAL, chosen},
    far_off::far_off,
    path::{Direction, minimum_curvature},
    placed::{Placed, Shot, placed},
    position_errors::horizontal_ellipse,
    reference::{Provenance, Reference, ReferenceAt},
    run_code::{terms, tool_code},
    settings::{Correction, RunSettings},
    stations_csv::{Measured, ReadStation},
    term_weights::ModelStation,
};
use crate::failure::Failure;

/// Smallest fall of the depth from one station to the next that is an error and not the rounding of one depth, metres.
const FALL_M: f64 = 0.01;
/// Standard gravity, m/s^2.
const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

/// Result for a run.
#[derive(Debug, Serialize)]
pub struct SurveyedRun {
    /// Name of the well.
    pub well: String,
    /// Correction that was asked for.
    pub correction: Correction,
    /// Sag that was added to the inclinations, in words; `None` where none was.
    pub sag: Option<String>,
    /// Origin of the reference.
    pub provenance: Provenance,
    /// Convergence of the grid, degrees; `None` without one: azimuths and positions then count from true north.
    pub convergence_deg: Option<f64>,
    /// Azimuth of the vertical section, degrees.
    pub vertical_section_deg: f64,
    /// Tool codes of the stations, that of the covariances, each once.
    pub tool_codes: Vec<String>,
    /// The multi-station analysis, if one was made.
    pub analysis: Option<Analysis>,
    /// What is doubtful, a sentence each.
    pub warnings: Vec<String>,
    /// Stations.
    pub stations: Vec<SurveyedStation>,
}

/// A multi-station analysis in numbers and words.
#[derive(Debug, Serialize)]
pub struct Analysis {
    /// Number of stations that it rests on.
    pub counted: usize,
    /// What became of the azimuths.
    pub azimuth: String,
    /// What became of the inclinations.
    pub inclination: String,
    /// Residuals' variance over the stated noise's.
    pub noise_ratio: f32,
    /// Rms of the residuals in units of the noise: uncorrected, and of stations as the others predict them.
    pub residual: [f32; 2],
    /// Whether the drill string's field grew over the run.
    pub axial_field_grows: bool,
    /// Common errors: name, value, sigma, sigma before, and whether the stations determine it.
    pub estimates: Vec<(&'static str, f32, f32, f32, bool)>,
}

/// Result for one station. Angles are in degrees, lengths in metres.
#[derive(Clone, Debug, Serialize)]
pub struct SurveyedStation {
    /// Measured depth.
    pub md_m: f64,
    /// Reference at this depth.
    pub reference: ReferenceAt,
    /// Model that it comes from.
    pub reference_model: String,
    /// Day that the model was evaluated for.
    pub reference_date: String,
    /// Convergence of the grid; `None` without one.
    pub convergence_deg: Option<f64>,
    /// Mean force, m/s^2, and field, microtesla, tool axes; `None` if the file gave angles.
    pub readings: Option<[[f64; 3]; 2]>,
    /// Inclination and magnetic azimuth as measured.
    pub measured_deg: [f64; 2],
    /// Inclination of the hole, corrected, sag included. Stations at one depth share their mean direction.
    pub inclination_deg: f64,
    /// Its standard deviation; `None` where only angles were read.
    pub sigma_inclination_deg: Option<f64>,
    /// Azimuth from magnetic north, corrected.
    pub magnetic_azimuth_deg: f64,
    /// Its standard deviation.
    pub sigma_magnetic_azimuth_deg: Option<f64>,
    /// Azimuth from the north of positions: grid, or true without a grid.
    pub azimuth_deg: f64,
    /// Its standard deviation, the declination's included.
    pub sigma_azimuth_deg: Option<f64>,
    /// Gravity toolface; `None` where only angles were read.
    pub gravity_toolface_deg: Option<f64>,
    /// Measured less reference |G| m/s^2, |B| microtesla, dip degrees.
    pub off_reference: Option<[f64; 3]>,
    /// Sag that was added to the inclination.
    pub sag_deg: f64,
    /// Whether the azimuth was corrected, and how.
    pub corrected: &'static str,
    /// Tool code.
    pub tool_code: String,
    /// Axial interference by the reference, microtesla, and its standard deviation.
    pub axial_interference_ut: Option<[f64; 2]>,
    /// True in the no-go zone of the short-collar correction.
    pub axial_no_go: Option<bool>,
    /// True if the other stations contradict this one.
    pub doubted: bool,
    /// North, east, true vertical depth.
    pub position_m: [f64; 3],
    /// Bend since the station before, degrees over 30 m.
    pub dogleg_deg_30m: f64,
    /// Distance along the vertical section.
    pub vertical_section_m: f64,
    /// Covariance of the position, row by row: north, east, down; m^2.
    pub covariance_m2: [[f64; 3]; 3],
    /// Half axes of the horizontal ellipse of one standard deviation, and the azimuth of the larger, degrees.
    pub ellipse: [f64; 3],
}

impl SurveyedRun {
    /// What became of the sag, in words: how it is known, and what was added.
    #[must_use]
    pub fn sag_told(&self) -> String {
        let Some(how) = &self.sag else { return "none corrected".to_owned() };
        let added = || self.stations.iter().map(|station| station.sag_deg);
        let (least, most) = (added().fold(f64::MAX, f64::min), added().fold(f64::MIN, f64::max));
        format!("{how}; {least:.3} to {most:.3} deg are added to the measured inclinations")
    }
}

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
    let (report, places) = analysed(&pending, settings, &mut warnings);
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
    let off: Vec<[f64; 3]> = stations.iter().filter_map(|station| station.off_reference).collect();
    warnings.extend(far_off(&off));
    for station in &mut stations {
        station.tool_code = code.name(station.corrected == AXIAL);
    }
    let shots: Vec<Shot> = stations.iter().map(shot).collect();
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
        analysis: report.as_ref().map(told),
        warnings,
        stations,
    })
}

/// How the sag is known, in words; `None` where none is to be added.
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
        let [inclination_rad, azimuth_rad] = measured_angles(&station.measured).ok_or_else(|| {
            Failure::BadInput(format!("station {} at {md_m:.2} m: {}", k + 1, unusable(&station.measured)))
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

/// Analyses the stations together: all, or of more than the analysis holds as many, evenly spread. Returns with the
/// report which stations those are.
fn analysed(
    pending: &[Pending],
    settings: &RunSettings,
    warnings: &mut Vec<String>,
) -> (Option<MultiStationReport>, Vec<usize>) {
    let six: Vec<(usize, Station)> = pending.iter().enumerate().filter_map(|(k, p)| Some((k, p.station?))).collect();
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

/// Position of the first station.
fn start(settings: &RunSettings, first: Option<&Direction>) -> Vector3<f64> {
    let below = [0.0, 0.0, first.map_or(0.0, |first| first.md_m)];
    Vector3::from(settings.start_m.unwrap_or(below))
}

/// Inclination and magnetic azimuth, radians.
fn measured_angles(measured: &Measured) -> Option<[f64; 2]> {
    match measured {
        Measured::Angles { inclination_rad, magnetic_azimuth_rad } => Some([*inclination_rad, *magnetic_azimuth_rad]),
        Measured::SixAxis { force_m_s2, field_ut } => {
            let down = -force_m_s2.try_normalize(1.0)?;
            let east = down.cross(field_ut).try_normalize(1e-3)?;
            let north = east.cross(&down);
            let across = libm::hypot(north.z, east.z);
            Some([libm::atan2(across, down.z), libm::atan2(east.z, north.z)])
        }
    }
}

/// Why readings give no angles.
fn unusable(measured: &Measured) -> String {
    match measured {
        Measured::SixAxis { force_m_s2, field_ut } => {
            let [gravity, field] = [force_m_s2.norm(), field_ut.norm()];
            let which = if gravity < 0.5 * STANDARD_GRAVITY_M_S2 { "gravity" } else { "field" };
            format!(
                "gravity of {gravity:.4} m/s^2 and a field of {field:.4} microtesla give no direction: check the unit and the values \
                 of the {which} columns"
            )
        }
        Measured::Angles { .. } => "no angles".to_owned(),
    }
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
    let measured = measured_angles(&pending.read.measured).unwrap_or_default();
    let corrected = pending.station.and_then(|station| report?.corrected(&station));
    let axial = pending.station.and_then(|station| AxialCorrection::of(&station, &settings.errors));
    let (inclination, azimuth, how) = chosen(settings, measured, corrected, axial, report);
    let modelled = || settings.sag.map(|sag| sag.correction_rad(inclination.value).to_degrees());
    let sag_deg = pending.read.sag_deg.or_else(modelled).unwrap_or(0.0);
    let declination = libm::hypot(
        f64::from(settings.errors.declination_rad),
        f64::from(settings.errors.declination_rad_ut)
            / (reference.field_ut * libm::cos(reference.dip_deg.to_radians())),
    );
    let azimuth_deg = azimuth.value.to_degrees() + reference.declination_deg - convergence_deg.unwrap_or(0.0);
    let readings = match pending.read.measured {
        Measured::SixAxis { force_m_s2, field_ut } => Some((force_m_s2, field_ut)),
        Measured::Angles { .. } => None,
    };
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

fn told(report: &MultiStationReport) -> Analysis {
    let decision = |decision| match decision {
        Decision::Corrected => "corrected".to_owned(),
        Decision::Refused(reason) => format!("as measured: {}", reason.told()),
        _ => "as measured".to_owned(),
    };
    Analysis {
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

/// Degrees within 0 to 360.
fn turn(degrees: f64) -> f64 {
    let within = remainder(degrees, 360.0);
    if within < 0.0 { within + 360.0 } else { within }
}
