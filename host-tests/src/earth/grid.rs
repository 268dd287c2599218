//! Convergence of a map's grid: by how much grid north lies east of true north.

/// Squared second eccentricity of the WGS 84 ellipsoid.
const SECOND_ECCENTRICITY_SQUARED: f64 = 6.739_496_742_28e-3;

/// Grid of a map.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Grid {
    /// A stated convergence, degrees, positive where grid north is east of true north.
    ConvergenceDeg(f64),
    /// The zone of Universal Transverse Mercator, 1 to 60.
    UtmZone(u8),
    /// A transverse Mercator map by its central meridian, degrees east.
    CentralMeridianDeg(f64),
    /// A Lambert conformal conic map: central meridian, degrees east, and the two standard parallels, degrees north.
    Lambert {
        /// Degrees east.
        central_meridian_deg: f64,
        /// Degrees north; the same twice for one standard parallel.
        parallels_deg: [f64; 2],
    },
}

impl Grid {
    /// Convergence at a place, degrees.
    ///
    /// Transverse Mercator: the series of J. P. Snyder, Map projections: a working manual (USGS 1395, 1987), in the
    /// distance from the central meridian; within 3 deg of it the next term is under 1e-5 deg. Lambert: the distance
    /// times the cone's constant (the same, 15).
    #[must_use]
    pub fn convergence_deg(&self, latitude_deg: f64, longitude_deg: f64) -> f64 {
        match *self {
            Self::ConvergenceDeg(degrees) => degrees,
            Self::UtmZone(zone) => transverse(latitude_deg, longitude_deg - (6.0 * f64::from(zone) - 183.0)),
            Self::CentralMeridianDeg(meridian) => transverse(latitude_deg, longitude_deg - meridian),
            Self::Lambert { central_meridian_deg, parallels_deg } => {
                libm::remainder(longitude_deg - central_meridian_deg, 360.0) * cone(parallels_deg)
            }
        }
    }
}

fn transverse(latitude_deg: f64, from_meridian_deg: f64) -> f64 {
    let (sine, cosine) = libm::sincos(latitude_deg.to_radians());
    let east = libm::remainder(from_meridian_deg, 360.0).to_radians();
    let eta2 = SECOND_ECCENTRICITY_SQUARED * cosine * cosine;
    let (square, tangent2) = (east * east * cosine * cosine, sine * sine / (cosine * cosine));
    let series =
        1.0 + square / 3.0 * (1.0 + 3.0 * eta2 + 2.0 * eta2 * eta2) + square * square / 15.0 * (2.0 - tangent2);
    (east * sine * series).to_degrees()
}

/// Constant of the cone through two parallels of the ellipsoid (Snyder, 15-8).
fn cone([first, second]: [f64; 2]) -> f64 {
    let eccentricity2 = SECOND_ECCENTRICITY_SQUARED / (1.0 + SECOND_ECCENTRICITY_SQUARED);
    let e = libm::sqrt(eccentricity2);
    let logarithms = |degrees: f64| {
        let (sine, cosine) = libm::sincos(degrees.to_radians());
        let m = cosine / libm::sqrt(1.0 - eccentricity2 * sine * sine);
        let t = libm::tan(std::f64::consts::FRAC_PI_4 - 0.5 * degrees.to_radians())
            / libm::pow((1.0 - e * sine) / (1.0 + e * sine), 0.5 * e);
        (libm::log(m), libm::log(t))
    };
    if (first - second).abs() < 1e-6 {
        return libm::sin(first.to_radians());
    }
    let ((m1, t1), (m2, t2)) = (logarithms(first), logarithms(second));
    (m1 - m2) / (t1 - t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Meridian convergence by PROJ 9 (`pyproj.Proj.get_factors`): latitude, longitude, convergence, degrees.
    const UTM_31: [(f64, f64, f64); 5] = [
        (60.0, 2.0, -0.866047),
        (60.0, 5.9, 2.512012),
        (5.0, 0.2, -0.244233),
        (-35.0, 1.0, 1.147470),
        (72.0, 4.0, 0.951066),
    ];
    /// The same of a Lambert map with parallels of 28.38333 and 30.28333 deg N about 99 deg W (Texas South Central).
    const TEXAS: [(f64, f64, f64); 2] = [(29.5, -97.0, 0.979825), (28.9, -101.3, -1.126799)];

    #[test]
    fn the_convergence_is_that_of_an_independent_library() {
        for (latitude, longitude, expected) in UTM_31 {
            for turn in [0.0, 360.0, -360.0] {
                let found = Grid::UtmZone(31).convergence_deg(latitude, longitude + turn);
                assert!((found - expected).abs() < 2e-5, "{latitude} {longitude}: {found} {expected}");
                assert!(
                    (Grid::CentralMeridianDeg(3.0).convergence_deg(latitude, longitude + turn) - found).abs() < 1e-9
                );
            }
        }
        let texas = Grid::Lambert { central_meridian_deg: -99.0, parallels_deg: [28.383_333_333, 30.283_333_333] };
        for (latitude, longitude, expected) in TEXAS {
            let found = texas.convergence_deg(latitude, longitude);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert!((Grid::ConvergenceDeg(-1.25).convergence_deg(60.0, 2.0) + 1.25).abs() < 1e-12);
    }
}
