//! Verdict on a fit: whether it may go on record.

use meerkat_mwd::compensation::VectorModel;
use nalgebra::{Matrix3, Vector3};

use super::{
    held_out::HeldOut,
    model::{Model, NAMES, Parameters},
    norm_fit::{Fit, Observation, Problem},
};

/// Largest harmless error of a calibrated direction, rad (0.3 deg): the least change of rotation for which
/// the library swaps P. Vectors that judge P must not be off by more.
pub const LARGEST_HARMLESS_RAD: f64 = 5.2e-3;

/// Number of its own deviations by which a change must stand out if the new values may exceed
/// [`LARGEST_HARMLESS_RAD`], as in the library: the error removed is then ten times the error added, in
/// square.
const LEAST_CHANGE_SIGMAS: f64 = 3.0;

/// Ratio of a parameter's deviation after and before above which it is named as not determined, as in the
/// library.
const DETERMINED: f64 = 0.5;

/// Reason why old values stay where neither the field's strength nor the parameters can be told from the turns.
pub(super) const TOO_FEW_TURNS: &str =
    "the turns do not suffice: turn the probe about all of its axes, through all directions, away from iron";

/// Returns true if the readings leave nothing that figures could be told of: no freedom to check by, or values that are
/// those of no sensor.
#[must_use]
pub fn is_beyond_figures(fit: &Fit) -> bool {
    fit.freedom < 1.0 || !VectorModel::from(fit.model).is_valid()
}

/// Decision about a sensor's new values: whether they go on record, and why not.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// All nine parameters are new; directions are right to 0.3 deg (95 %).
    Calibrated,
    /// The directions that the motion determined are new; the others are kept from the record.
    Partly(String),
    /// The old values stay, for this reason.
    Kept(String),
}

/// Requirement that new values must meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// Good enough to judge a gyro by: no direction is off by more than [`LARGEST_HARMLESS_RAD`]. The library
    /// lets gravity alone judge P once an accelerometer calibration is on record.
    ToJudgeBy,
    /// Clearly better than the old values: the change of direction stands out from its own deviation.
    ClearlyBetter,
}

/// Bounds (95 %) on the error of a calibrated vector of any direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Error of the norm, as a share of it.
    pub norm: f64,
    /// Error of the direction, rad.
    pub direction_rad: f64,
    /// The direction with the largest error, sensor axes.
    pub worst: Vector3<f64>,
    /// Deviation of the direction, rad, rms over all directions.
    pub sigma_rad: f64,
    /// Change of the direction by the new values, rad, rms over all directions.
    pub change_rad: f64,
}

impl Bounds {
    /// Computes the bounds at this norm over directions all around.
    #[must_use]
    pub fn of(fit: &Fit, record: &Model, norm: f64) -> Self {
        let mut bounds = Self { norm: 0.0, direction_rad: 0.0, worst: Vector3::x(), sigma_rad: 0.0, change_rad: 0.0 };
        let (mut variance, mut change_square) = (0.0, 0.0);
        let inverse = fit.model.matrix.try_inverse().unwrap_or_else(Matrix3::identity);
        for direction in all_around() {
            let raw = inverse * direction * norm + fit.model.offset;
            change_square += record.calibrate(&raw).angle(&direction).powi(2);
            let change = fit.model.sensitivity(record, &raw);
            let covariance = change * fit.covariance * change.transpose() / (norm * norm);
            let across = Matrix3::identity() - direction * direction.transpose();
            let sideways = (across * covariance * across).symmetric_eigenvalues().amax();
            variance += (across * covariance).trace();
            let along = (direction.transpose() * covariance * direction)[(0, 0)];
            bounds.norm = bounds.norm.max(fit.quantile() * along.max(0.0).sqrt());
            let direction_rad = fit.quantile() * sideways.max(0.0).sqrt();
            if direction_rad > bounds.direction_rad {
                (bounds.direction_rad, bounds.worst) = (direction_rad, direction);
            }
        }
        let mean = |sum: f64| (sum / f64::from(ALL_AROUND)).max(0.0).sqrt();
        Self { sigma_rad: mean(variance), change_rad: mean(change_square), ..bounds }
    }
}

/// Number of directions tried: enough to find any ellipsoid's worst one to 10 deg.
const ALL_AROUND: u32 = 200;

/// Directions evenly spread over the sphere (Fibonacci's spiral).
fn all_around() -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..ALL_AROUND).map(move |k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(ALL_AROUND);
        let radius = (1.0 - z * z).sqrt();
        let (sine, cosine) = (golden * f64::from(k)).sin_cos();
        Vector3::new(radius * cosine, radius * sine, z)
    })
}

/// Spread of the directions that a sensor saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Number of directions more than [`APART_DEG`] from each other.
    pub orientations: usize,
    /// Smallest mean square component of the unit vectors along any axis: 1/3 all around, 0 in a plane.
    pub smallest: f64,
}

/// Angle within which two directions count as one, degrees.
pub const APART_DEG: f64 = 10.0;

impl Spread {
    /// The spread of the readings used.
    #[must_use]
    pub fn of(fit: &Fit, observations: &[Observation]) -> Self {
        let used = observations.iter().zip(&fit.used).filter(|(_, used)| **used);
        let units: Vec<Vector3<f64>> = used.map(|(o, _)| fit.model.calibrate(&o.raw).normalize()).collect();
        let mut apart: Vec<Vector3<f64>> = Vec::new();
        for unit in &units {
            if apart.iter().all(|other| other.dot(unit) < APART_DEG.to_radians().cos()) {
                apart.push(*unit);
            }
        }
        let scatter =
            units.iter().map(|unit| unit * unit.transpose()).sum::<Matrix3<f64>>() / units.len().max(1) as f64;
        Self { orientations: apart.len(), smallest: scatter.symmetric_eigenvalues().min().max(0.0) }
    }
}

/// Names of parameters that the readings do not determine.
#[must_use]
pub fn undetermined_of(prior: &Parameters, fit: &Fit) -> Vec<&'static str> {
    let allowance = fit.quantile() / 1.96;
    let sigma = fit.sigma();
    let open = |k: &usize| {
        let determined = sigma[*k] * allowance < DETERMINED * prior[*k];
        !determined
    };
    (0..NAMES.len()).filter(open).map(|k| NAMES[k]).collect()
}

/// Verdict on a fit. `on_record` tells whether the old values come from a calibration.
#[must_use]
pub fn judge(
    problem: &Problem,
    fit: &Fit,
    bounds: &Bounds,
    held_out: Option<&HeldOut>,
    on_record: bool,
    standard: Standard,
) -> Verdict {
    let count = fit.used.iter().filter(|used| **used).count();
    if fit.torn {
        return Verdict::Kept(format!("more than a quarter of {} readings disagree with the others", fit.used.len()));
    }
    if fit.rank == 0 || (fit.rank == NAMES.len() && fit.freedom < 1.0) {
        return Verdict::Kept(format!("{count} readings for 9 parameters leave nothing to check them by"));
    }
    let is_sensor = VectorModel::from(fit.model).is_valid();
    if fit.rank == NAMES.len() && !is_sensor {
        return Verdict::Kept("the fit is no sensor: its matrix mirrors or flattens".into());
    }
    // Conditions are written for what passes, so that a NaN is refused.
    let no_worse = held_out.is_none_or(|check| check.after < check.before);
    let no_better = || Verdict::Kept("on readings that were held out it is no better than the old values".into());
    if fit.rank == NAMES.len() && !no_worse {
        return no_better();
    }
    let open = undetermined_of(&problem.prior, fit);
    let reason = if fit.rank < NAMES.len() {
        let names = if open.is_empty() { "a combination of them".into() } else { open.join(", ") };
        format!("the motion determines {} of 9 directions of the parameters, not {names}", fit.rank)
    } else if bounds.direction_rad < LARGEST_HARMLESS_RAD
        || (standard == Standard::ClearlyBetter && bounds.change_rad > LEAST_CHANGE_SIGMAS * bounds.sigma_rad)
    {
        return if held_out.is_some() {
            Verdict::Calibrated
        } else {
            Verdict::Kept("there are too few readings to hold any out".into())
        };
    } else {
        let [x, y, z] = bounds.worst.into();
        let found = bounds.direction_rad.to_degrees();
        let limit = match standard {
            Standard::ToJudgeBy => format!("{:.1} are allowed", LARGEST_HARMLESS_RAD.to_degrees()),
            Standard::ClearlyBetter => format!(
                "and the change of {:.2} deg is no {LEAST_CHANGE_SIGMAS:.0} times its own deviation of {:.2}",
                bounds.change_rad.to_degrees(),
                bounds.sigma_rad.to_degrees()
            ),
        };
        format!("directions can be off by {found:.2} deg (95 %, about [{x:.1} {y:.1} {z:.1}]), {limit}")
    };
    // A record is changed only by values that readings speak for which they were not fitted to.
    match held_out {
        _ if !(on_record && is_sensor) => Verdict::Kept(reason),
        None => Verdict::Kept(format!("{reason}; and there are too few readings to hold any out")),
        Some(_) if no_worse => Verdict::Partly(reason),
        Some(_) => no_better(),
    }
}
