//! Covariance of positions by the ISCWSA's MWD error model, revision 4: terms, weights and propagation of H.
//! Williamson, SPE 67616 (2000), with the toolface-independent forms of the revision.
//!
//! A term's error turns a station by dI and dA and moves it by dD along the hole. Azimuth enters as sin(I) dA, which is
//! finite at the vertical, so that no term is singular there. Positions follow by the balanced tangential method, as
//! the model prescribes.

use libm::{cos, sin, tan};
use meerkat_mwd::config::SurveyErrors;
use nalgebra::{Matrix3, Vector3};

use super::path::Direction;

/// A station as the error model sees it.
#[derive(Clone, Copy, Debug)]
pub struct ModelStation {
    /// Depth and direction, azimuth from the north that positions count from.
    pub direction: Direction,
    /// True vertical depth, metres.
    pub tvd_m: f64,
    /// Azimuth from magnetic north, radians.
    pub magnetic_azimuth_rad: f64,
    /// Azimuth from true north, radians.
    pub true_azimuth_rad: f64,
    /// Reference's total field, microtesla, dip, radians, and gravity, m/s^2.
    pub field_ut: f64,
    /// Dip, radians.
    pub dip_rad: f64,
    /// Gravity, m/s^2.
    pub gravity_m_s2: f64,
}

/// Correlation of a term between stations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Propagation {
    Random,
    /// The same at all stations: of one run, of one well, everywhere.
    Systematic,
}

/// Errors of the depth and of the tool in the hole, beside those of [`SurveyErrors`]; defaults of revision 4, fixed
/// rig.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PositionErrors {
    /// Depth reference at each station, metres (DRFR).
    pub depth_reference_m: f64,
    /// Scale of the depth (DSFS).
    pub depth_scale: f64,
    /// Stretch of the drill string, 1/m (DSTG).
    pub depth_stretch_1_m: f64,
    /// Sag of the bottom-hole assembly in the vertical plane, degrees (SAG).
    pub sag_deg: f64,
    /// Misalignment of the tool in the hole, degrees (XYM1 to XYM4).
    pub misalignment_deg: f64,
    /// Random part of the declination, degrees (DECR).
    pub declination_random_deg: f64,
    /// Random part of the declination, degree nanotesla, over the horizontal field (DBHR).
    pub declination_random_deg_nt: f64,
}

impl Default for PositionErrors {
    fn default() -> Self {
        Self {
            depth_reference_m: 0.35,
            depth_scale: 5.6e-4,
            depth_stretch_1_m: 2.5e-7,
            sag_deg: 0.2,
            misalignment_deg: 0.1,
            declination_random_deg: 0.1,
            declination_random_deg_nt: 3_000.0,
        }
    }
}

/// Weights of a term at a station: depth, inclination, and azimuth times sin(I).
type Weights = [f64; 3];

struct Term {
    propagation: Propagation,
    weights: Vec<Weights>,
}

/// Covariances of the stations' positions, north, east and down, m^2. The first station is the start and has none.
#[must_use]
pub fn covariances(stations: &[ModelStation], sensors: &SurveyErrors, errors: &PositionErrors) -> Vec<Matrix3<f64>> {
    let mut sums = vec![Matrix3::zeros(); stations.len()];
    for term in terms(stations, sensors, errors) {
        add(&mut sums, stations, &term);
    }
    sums
}

/// Adds a term's covariance: at the station itself the error of the leg before it, further down that of both legs.
fn add(sums: &mut [Matrix3<f64>], stations: &[ModelStation], term: &Term) {
    let (mut carried, mut carried_square) = (Vector3::zeros(), Matrix3::zeros());
    for (k, (sum, weights)) in sums.iter_mut().zip(&term.weights).enumerate().skip(1) {
        let last = moved(stations, k, weights, false);
        *sum += match term.propagation {
            Propagation::Systematic => outer(&(carried + last)),
            Propagation::Random => carried_square + outer(&last),
        };
        let through = moved(stations, k, weights, true);
        carried += through;
        carried_square += outer(&through);
    }
}

fn outer(v: &Vector3<f64>) -> Matrix3<f64> {
    v * v.transpose()
}

/// Change of the position at station `k`, or of those further down, by its own error.
fn moved(stations: &[ModelStation], k: usize, [depth, inclination, across]: &Weights, further: bool) -> Vector3<f64> {
    let at = |k: usize| stations.get(k).map(|station| station.direction);
    let (Some(before), Some(here)) = (k.checked_sub(1).and_then(at), at(k)) else { return Vector3::zeros() };
    let after = if further { at(k + 1) } else { None };
    let length = here.md_m - before.md_m + after.map_or(0.0, |after| after.md_m - here.md_m);
    let (si, ci) = libm::sincos(here.inclination_rad);
    let (sa, ca) = libm::sincos(here.azimuth_rad);
    let turned = Vector3::new(ci * ca, ci * sa, -si) * *inclination + Vector3::new(-sa, ca, 0.0) * *across;
    let leg = match after {
        Some(after) => (before.tangent() - after.tangent()) * 0.5,
        None => (before.tangent() + here.tangent()) * 0.5,
    };
    leg * *depth + turned * (0.5 * length)
}

/// All terms with their weights, multiplied by their standard deviations.
fn terms(stations: &[ModelStation], sensors: &SurveyErrors, errors: &PositionErrors) -> Vec<Term> {
    use Propagation::{Random, Systematic};
    type Weigh = fn(&At) -> Weights;
    let [accel_bias, accel_scale] = [sensors.accel_bias_m_s2, sensors.accel_scale].map(f64::from);
    let [mag_bias, mag_scale] = [sensors.mag_bias_ut, sensors.mag_scale].map(f64::from);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let misalignment = errors.misalignment_deg.to_radians();
    // Names as in the model. Each line: standard deviation, propagation, weights.
    let list: [(f64, Propagation, Weigh); 27] = [
        (errors.depth_reference_m, Random, |_| [1.0, 0.0, 0.0]),
        (errors.depth_scale, Systematic, |a| [a.md, 0.0, 0.0]),
        (errors.depth_stretch_1_m, Systematic, |a| [a.md * a.tvd, 0.0, 0.0]),
        // ABXY-TI1, ABXY-TI2, ABZ
        (accel_bias, Systematic, |a| [0.0, -a.ci / a.g, a.si * a.ci * a.td * a.sm / a.g]),
        (accel_bias, Systematic, |a| [0.0, 0.0, (a.ci - a.td * a.si * a.cm) / a.g]),
        (accel_bias, Systematic, |a| [0.0, -a.si / a.g, a.si * a.si * a.td * a.sm / a.g]),
        // ASXY-TI1 to TI3, ASZ
        (accel_scale * half, Systematic, |a| [0.0, a.si * a.ci, -a.si * a.si * a.td * a.ci * a.sm]),
        (accel_scale * 0.5, Systematic, |a| [0.0, a.si * a.ci, -a.si * a.si * a.td * a.ci * a.sm]),
        (accel_scale * 0.5, Systematic, |a| [0.0, 0.0, a.si * (a.si * a.td * a.cm - a.ci)]),
        (accel_scale, Systematic, |a| [0.0, -a.si * a.ci, a.si * a.si * a.ci * a.td * a.sm]),
        // MBXY-TI1, MBXY-TI2, MBZ
        (mag_bias, Systematic, |a| [0.0, 0.0, -a.si * a.ci * a.sm / a.bh]),
        (mag_bias, Systematic, |a| [0.0, 0.0, a.si * a.cm / a.bh]),
        (mag_bias, Systematic, |a| [0.0, 0.0, -a.si * a.si * a.sm / a.bh]),
        // MSXY-TI1 to TI3, MSZ
        (mag_scale * half, Systematic, |a| [0.0, 0.0, a.si * a.si * a.sm * (a.td * a.ci + a.si * a.cm)]),
        (mag_scale * 0.5, Systematic, |a| [0.0, 0.0, a.si * a.sm * (a.td * a.si * a.ci - a.ci * a.ci * a.cm - a.cm)]),
        (mag_scale * 0.5, Systematic, |a| [0.0, 0.0, a.si * (a.ci * (a.cm * a.cm - a.sm * a.sm) - a.td * a.si * a.cm)]),
        (mag_scale, Systematic, |a| [0.0, 0.0, -a.si * (a.si * a.cm + a.td * a.ci) * a.si * a.sm]),
        // DECG, DECR, DBHG, DBHR
        (f64::from(sensors.declination_rad), Systematic, |a| [0.0, 0.0, a.si]),
        (errors.declination_random_deg.to_radians(), Random, |a| [0.0, 0.0, a.si]),
        (f64::from(sensors.declination_rad_ut), Systematic, |a| [0.0, 0.0, a.si / a.bh]),
        (errors.declination_random_deg_nt.to_radians() * 1e-3, Random, |a| [0.0, 0.0, a.si / a.bh]),
        // AMIL
        (f64::from(sensors.axial_interference_ut), Systematic, |a| [0.0, 0.0, -a.si * a.si * a.sm / a.bh]),
        // SAG, XYM1 to XYM4
        (errors.sag_deg.to_radians(), Systematic, |a| [0.0, a.si, 0.0]),
        (misalignment, Systematic, |a| [0.0, a.si.abs(), 0.0]),
        (misalignment, Systematic, |a| [0.0, 0.0, -a.si]),
        (misalignment, Systematic, |a| [0.0, a.ci.abs() * a.ct, -a.ci.abs() * a.st]),
        (misalignment, Systematic, |a| [0.0, a.ci.abs() * a.st, a.ci.abs() * a.ct]),
    ];
    let at: Vec<At> = stations.iter().map(At::of).collect();
    list.into_iter()
        .map(|(sigma, propagation, weigh)| Term {
            propagation,
            weights: at.iter().map(|at| weigh(at).map(|weight| sigma * weight)).collect(),
        })
        .collect()
}

/// Sines and cosines of one station: inclination i, magnetic azimuth m, true azimuth t; tangent of the dip, horizontal
/// field and gravity.
struct At {
    si: f64,
    ci: f64,
    sm: f64,
    cm: f64,
    st: f64,
    ct: f64,
    td: f64,
    bh: f64,
    g: f64,
    md: f64,
    tvd: f64,
}

impl At {
    fn of(station: &ModelStation) -> Self {
        let (si, ci) = libm::sincos(station.direction.inclination_rad);
        let (sm, cm) = libm::sincos(station.magnetic_azimuth_rad);
        let (st, ct) = (sin(station.true_azimuth_rad), cos(station.true_azimuth_rad));
        let bh = station.field_ut * cos(station.dip_rad);
        let (td, g) = (tan(station.dip_rad), station.gravity_m_s2);
        Self { si, ci, sm, cm, st, ct, td, bh, g, md: station.direction.md_m, tvd: station.tvd_m }
    }
}

/// Half axes of the horizontal ellipse of one standard deviation, metres, the larger first, and the azimuth of that
/// one, radians, 0 to pi.
#[must_use]
pub fn horizontal_ellipse(covariance: &Matrix3<f64>) -> ([f64; 2], f64) {
    let (nn, ee, ne) = (covariance.m11, covariance.m22, covariance.m12);
    let (mean, spread) = (0.5 * (nn + ee), libm::hypot(0.5 * (nn - ee), ne));
    let axes = [mean + spread, (mean - spread).max(0.0)].map(libm::sqrt);
    let azimuth = 0.5 * libm::atan2(2.0 * ne, nn - ee);
    (axes, if azimuth < 0.0 { azimuth + std::f64::consts::PI } else { azimuth })
}
