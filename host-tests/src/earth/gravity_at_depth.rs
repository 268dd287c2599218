//! Gravity down a well.

use super::normal_gravity::normal_gravity_m_s2;

/// Density of rock, kg/m^3: the usual mean of the upper crust (Bouguer's reduction takes it).
pub const ROCK_KG_M3: f64 = 2_670.0;
/// Constant of gravitation, m^3/(kg s^2) (CODATA 2018).
const GRAVITATION: f64 = 6.674_3e-11;
/// Free-air gradient, 1/s^2: gravity lost by each metre up.
const FREE_AIR_S2: f64 = 3.086e-6;

/// Gravity at a geodetic latitude (degrees) and a height above the ellipsoid (metres), m/s^2, under a surface at
/// `surface_m` above the ellipsoid: the free-air gradient down to the surface, then that of rock. Each metre down in
/// rock of density rho adds the free-air gradient less 4 pi G rho (Poisson's equation); with 2,670 kg/m^3 that is
/// 0.85e-6 1/s^2, 0.43 mg in 5 km. Over water give the sea's surface and a mean density.
#[must_use]
pub fn gravity_m_s2(latitude_deg: f64, height_m: f64, surface_m: f64, rock_kg_m3: f64) -> f64 {
    let (above, depth) = if height_m < surface_m { (surface_m, surface_m - height_m) } else { (height_m, 0.0) };
    let in_rock = FREE_AIR_S2 - 4.0 * std::f64::consts::PI * GRAVITATION * rock_kg_m3;
    normal_gravity_m_s2(latitude_deg, above) + in_rock * depth
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gravity_rises_slower_in_rock_than_in_air_and_is_continuous_at_the_surface() {
        let at = |height_m| gravity_m_s2(60.0, height_m, 200.0, ROCK_KG_M3);
        assert!((at(200.001) - at(199.999)).abs() < 1e-8);
        // 0.0847 mGal a metre: the gradient that gravimeters measure down wells in rock of this density
        // (0.3086 - 0.0838 * 2.67, Hammer 1950).
        let milligal_a_metre = (at(-800.0) - at(200.0)) / 1_000.0 * 1e5;
        assert!((milligal_a_metre - (0.3086 - 0.083_8 * 2.67)).abs() < 3e-4, "{milligal_a_metre}");
        let in_water = gravity_m_s2(60.0, -1_000.0, 0.0, 1_025.0) - gravity_m_s2(60.0, 0.0, 0.0, 1_025.0);
        // 0.222 mGal a metre in sea water.
        assert!((in_water * 100.0 - 0.222).abs() < 1e-3, "{in_water}");
    }
}
