//! The well's path through its stations, by minimum curvature: a circle's arc from each station to the next, tangent to
//! the hole at both (S. J. Sawaryn and J. L. Thorogood, SPE 84246, 2005).

use nalgebra::Vector3;

/// Length to which doglegs are scaled, metres.
pub const DOGLEG_LENGTH_M: f64 = 30.0;
/// Dogleg below which the ratio factor is its series: the next term is under 1e-17.
const SMALL_RAD: f64 = 1e-2;

/// Direction of the hole at a depth along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Measured depth, metres.
    pub md_m: f64,
    /// Inclination from the vertical, radians.
    pub inclination_rad: f64,
    /// Azimuth from the north that positions count from, radians.
    pub azimuth_rad: f64,
}

/// Place of a station, and the hole's bend before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// North, east and down from the start, metres.
    pub position_m: Vector3<f64>,
    /// Bend since the station before, radians over 30 m; 0 at the first.
    pub dogleg_rad_30m: f64,
}

impl Direction {
    /// Unit vector down the hole: north, east, down.
    #[must_use]
    pub fn tangent(&self) -> Vector3<f64> {
        let (sine, cosine) = libm::sincos(self.inclination_rad);
        Vector3::new(sine * libm::cos(self.azimuth_rad), sine * libm::sin(self.azimuth_rad), cosine)
    }
}

impl PathPoint {
    /// Distance along a horizontal direction, metres: the vertical section.
    #[must_use]
    pub fn vertical_section_m(&self, azimuth_rad: f64) -> f64 {
        self.position_m.x * libm::cos(azimuth_rad) + self.position_m.y * libm::sin(azimuth_rad)
    }
}

/// Places of all stations, the first one at `start`.
#[must_use]
pub fn minimum_curvature(stations: &[Direction], start: Vector3<f64>) -> Vec<PathPoint> {
    let mut points: Vec<PathPoint> = Vec::with_capacity(stations.len());
    for (k, station) in stations.iter().enumerate() {
        let point = match (k.checked_sub(1).and_then(|before| stations.get(before)), points.last()) {
            (Some(before), Some(last)) => next(before, last, station),
            _ => PathPoint { position_m: start, dogleg_rad_30m: 0.0 },
        };
        points.push(point);
    }
    points
}

fn next(before: &Direction, last: &PathPoint, station: &Direction) -> PathPoint {
    let (from, to) = (before.tangent(), station.tangent());
    // Exact for small bends too, where the arc cosine is not.
    let dogleg = 2.0 * libm::atan2((to - from).norm(), (to + from).norm());
    let length = station.md_m - before.md_m;
    let half = dogleg / 2.0;
    let ratio =
        if dogleg < SMALL_RAD { 1.0 + half * half / 3.0 * (1.0 + 0.4 * half * half) } else { libm::tan(half) / half };
    PathPoint {
        position_m: last.position_m + (from + to) * (0.5 * length * ratio),
        dogleg_rad_30m: if length > 0.0 { dogleg / length * DOGLEG_LENGTH_M } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::indexing_slicing)]
    use super::*;

    fn direction(md_m: f64, inclination_deg: f64, azimuth_deg: f64) -> Direction {
        Direction { md_m, inclination_rad: inclination_deg.to_radians(), azimuth_rad: azimuth_deg.to_radians() }
    }

    #[test]
    fn a_circle_is_followed_exactly_whatever_the_distance_of_stations() {
        // 90 deg of a circle of 500 m to the north-east.
        let radius = 500.0;
        for count in [2, 3, 7, 100, 2_000] {
            let stations: Vec<Direction> = (0..=count)
                .map(|k| {
                    let angle = 90.0 * f64::from(k) / f64::from(count);
                    direction(radius * angle.to_radians(), angle, 45.0)
                })
                .collect();
            let end = *minimum_curvature(&stations, Vector3::zeros()).last().unwrap();
            let along = radius / std::f64::consts::SQRT_2;
            assert!((end.position_m - Vector3::new(along, along, radius)).norm() < 1e-8, "{count} {end:?}");
            assert!((end.dogleg_rad_30m - 30.0 / radius).abs() < 1e-12);
            assert!((end.vertical_section_m(45.0_f64.to_radians()) - radius).abs() < 1e-8);
        }
    }

    #[test]
    fn straight_holes_and_turns_through_north_and_through_the_vertical_have_no_singularity() {
        let straight =
            minimum_curvature(&[direction(0.0, 30.0, 350.0), direction(100.0, 30.0, 350.0)], Vector3::zeros());
        assert!((straight[1].position_m - direction(0.0, 30.0, 350.0).tangent() * 100.0).norm() < 1e-12);
        assert!(straight[1].dogleg_rad_30m < 1e-14);
        // 359 and 1 deg are 2 deg apart; 1 deg to either side of the vertical too.
        for (from, to) in [((90.0, 359.0), (90.0, 1.0)), ((1.0, 90.0), (1.0, 270.0))] {
            let stations = [direction(0.0, from.0, from.1), direction(30.0, to.0, to.1)];
            let bend = minimum_curvature(&stations, Vector3::zeros())[1].dogleg_rad_30m;
            assert!((bend.to_degrees() - 2.0).abs() < 1e-9, "{bend}");
        }
    }
}
