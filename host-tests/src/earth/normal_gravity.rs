//! Gravity of a place.

/// Gravity at a geodetic latitude (degrees) and a height above the ellipsoid (metres), m/s^2: Somigliana's
/// formula with the constants of WGS 84 (NGA.STND.0036, section 4.2) and the free-air gradient 3.086e-6 per
/// second squared. Local gravity differs by up to some 0.5 mg.
#[must_use]
pub fn normal_gravity_m_s2(latitude_deg: f64, height_m: f64) -> f64 {
    let sine = libm::sin(latitude_deg.to_radians());
    let square = sine * sine;
    9.780_325_335_9 * (1.0 + 1.931_852_652_41e-3 * square) / libm::sqrt(1.0 - 6.694_379_990_13e-3 * square)
        - 3.086e-6 * height_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_equator_the_pole_and_middle_latitude_are_the_published_ones() {
        // WGS 84: gravity at the equator and at the poles; GRS 80's 9.80620 at 45 deg (Moritz 2000) to the
        // digits in which they agree
        for (latitude_deg, published) in [(0.0, 9.780_325_335_9), (90.0, 9.832_184_937_8), (-90.0, 9.832_184_937_8)] {
            assert!((normal_gravity_m_s2(latitude_deg, 0.0) - published).abs() < 1e-9, "{latitude_deg}");
        }
        assert!((normal_gravity_m_s2(45.0, 0.0) - 9.806_20).abs() < 5e-6);
        assert!((normal_gravity_m_s2(45.0, 1_000.0) - normal_gravity_m_s2(45.0, 0.0) + 3.086e-3).abs() < 1e-9);
    }
}
