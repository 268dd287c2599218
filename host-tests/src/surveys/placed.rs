//! Places of stations with their uncertainty. Stations at one depth, as those of a cluster shot or of a roll test, are
//! one place of the hole: they share their mean direction, and errors that are drawn anew at each station come once.

use nalgebra::{Matrix3, Vector3};

use super::{
    far_off::at,
    path::{Direction, PathPoint, minimum_curvature},
    position_errors::covariances,
    term_weights::ModelStation,
    tool_codes::Term,
};

/// Distance along the hole under which two stations are at one place, metres: the rounding of a depth.
const ONE_PLACE_M: f64 = 0.01;

/// Angle between the directions of two stations of one place beyond which a warning names the place, degrees.
const APART_DEG: f64 = 1.0;

/// A station with its own direction; its true vertical depth is not known yet.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// The station.
    pub station: ModelStation,
    /// True if the other stations contradict it.
    pub doubted: bool,
}

/// A station at its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Mean direction of the stations here.
    pub direction: Direction,
    /// Place.
    pub point: PathPoint,
    /// Covariance of the place, m^2.
    pub covariance: Matrix3<f64>,
}

/// Places all stations, the first one at `start`.
#[must_use]
pub fn placed(shots: &[Shot], start: Vector3<f64>, terms: &[Term]) -> Vec<Placed> {
    let places = || shots.chunk_by(one_place);
    let mut model: Vec<ModelStation> = places().filter_map(model_station).collect();
    let directions: Vec<Direction> = model.iter().map(|station| station.direction).collect();
    let path = minimum_curvature(&directions, start);
    for (station, point) in model.iter_mut().zip(&path) {
        station.tvd_m = point.position_m.z;
    }
    let covariances = covariances(&model, terms);
    let at = directions.into_iter().zip(path).zip(covariances);
    let each = places().zip(at).flat_map(|(place, ((direction, point), covariance))| {
        std::iter::repeat_n(Placed { direction, point, covariance }, place.len())
    });
    each.collect()
}

fn one_place(one: &Shot, other: &Shot) -> bool {
    (one.station.direction.md_m - other.station.direction.md_m).abs() < ONE_PLACE_M
}

/// A sentence for the places whose stations lie further apart than that, by their depths; `None` if there is none.
#[must_use]
pub fn contradictions(shots: &[Shot]) -> Option<String> {
    let (mut depths, mut largest_deg) = (Vec::new(), 0.0);
    for place in shots.chunk_by(one_place) {
        let tangents: Vec<Vector3<f64>> = counted(place).map(|shot| shot.station.direction.tangent()).collect();
        let pairs =
            tangents.iter().enumerate().flat_map(|(k, one)| tangents.iter().skip(k + 1).map(move |two| one.angle(two)));
        let apart_deg = pairs.fold(0.0, f64::max).to_degrees();
        if let (true, Some(first)) = (apart_deg > APART_DEG, place.first()) {
            depths.push(format!("{:.1}", first.station.direction.md_m));
            largest_deg = f64::max(largest_deg, apart_deg);
        }
    }
    (!depths.is_empty()).then(|| {
        format!(
            "stations at one depth differ by up to {largest_deg:.1} deg in direction, and their mean is taken: {}",
            at(&depths)
        )
    })
}

/// The stations of a place that its direction is of: those that the others do not contradict, or all.
fn counted(place: &[Shot]) -> impl Iterator<Item = &Shot> {
    let all_doubted = place.iter().all(|shot| shot.doubted);
    place.iter().filter(move |shot| all_doubted || !shot.doubted)
}

/// The stations of a place as one, with the mean of their directions, without those that the others contradict.
fn model_station(place: &[Shot]) -> Option<ModelStation> {
    let first = place.first()?.station;
    if place.len() == 1 {
        return Some(first);
    }
    let mean: Vector3<f64> = counted(place).map(|shot| shot.station.direction.tangent()).sum();
    let direction = Direction {
        md_m: first.direction.md_m,
        inclination_rad: libm::atan2(libm::hypot(mean.x, mean.y), mean.z),
        azimuth_rad: libm::atan2(mean.y, mean.x),
    };
    let turned = direction.azimuth_rad - first.direction.azimuth_rad;
    Some(ModelStation {
        direction,
        magnetic_azimuth_rad: first.magnetic_azimuth_rad + turned,
        true_azimuth_rad: first.true_azimuth_rad + turned,
        axial: place.iter().all(|shot| shot.station.axial),
        ..first
    })
}
