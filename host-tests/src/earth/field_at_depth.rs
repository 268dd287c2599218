//! The World Magnetic Model's field below the heights that its evaluation takes.

use world_magnetic_model::{
    GeomagneticField,
    time::Date,
    uom::si::{
        angle::degree,
        f32::{Angle, Length},
        length::meter,
        magnetic_flux_density::microtesla,
    },
};

use super::reference_field::{ReferenceField, reference_field};
use testbed::failure::Failure;

/// Lowest height that the evaluation takes, metres.
const LOWEST_M: f64 = -1_000.0;
/// Deepest place, metres above the ellipsoid.
pub const DEEPEST_M: f64 = -12_000.0;
/// Heights through which the field's components are continued, metres.
const HEIGHTS_M: [f64; 6] = [-1_000.0, 40_000.0, 80_000.0, 120_000.0, 160_000.0, 200_000.0];

/// The field at a geodetic latitude (degrees north), a longitude (degrees east, any turn), a height above the
/// ellipsoid (metres) and a day.
///
/// Below 1 km the components are continued by the polynomial through six heights of the same model, whose harmonics
/// of degree n go with the power n + 2 of the inverse radius, n up to 12: by the remainder's formula the polynomial
/// errs by under 1e-6 nT at 12 km down, and the model's single precision by some 0.01 nT. No magnetised rock is in the
/// model, above or below.
///
/// # Errors
/// A place or a day outside the model: 2020 to 2029, 12 km below the ellipsoid to 850 km above.
pub fn field_at(latitude_deg: f64, longitude_deg: f64, height_m: f64, date: Date) -> Result<ReferenceField, Failure> {
    if !(-90.0..=90.0).contains(&latitude_deg) || !longitude_deg.is_finite() {
        return Err(Failure::BadInput(format!(
            "reference field: latitude {latitude_deg}, longitude {longitude_deg}: must be from -90 to 90 degrees north, and degrees east"
        )));
    }
    let longitude_deg = within_half_a_turn(longitude_deg);
    if height_m >= LOWEST_M {
        return reference_field(latitude_deg, longitude_deg, height_m, date);
    }
    if height_m < DEEPEST_M || height_m.is_nan() {
        return Err(Failure::BadInput(format!("reference field: {height_m} m is below {DEEPEST_M} m")));
    }
    let mut sum = [0.0; 3];
    for (k, at) in HEIGHTS_M.into_iter().enumerate() {
        let weight: f64 = (HEIGHTS_M.into_iter().enumerate())
            .filter(|&(other, _)| other != k)
            .map(|(_, other)| (height_m - other) / (at - other))
            .product();
        for (sum, value) in sum.iter_mut().zip(components_ut(latitude_deg, longitude_deg, at, date)?) {
            *sum += weight * value;
        }
    }
    let [x, y, z] = sum;
    let horizontal = libm::hypot(x, y);
    let highest = reference_field(latitude_deg, longitude_deg, LOWEST_M, date)?;
    Ok(ReferenceField {
        total_ut: libm::hypot(horizontal, z) as f32,
        dip_rad: libm::atan2(z, horizontal) as f32,
        declination_rad: libm::atan2(y, x) as f32,
        ..highest
    })
}

/// A longitude of any convention, 0 to 360 or beyond, as -180 to 180 degrees east.
#[must_use]
pub fn within_half_a_turn(longitude_deg: f64) -> f64 {
    libm::remainder(longitude_deg, 360.0)
}

/// North, east and down, microtesla.
fn components_ut(latitude_deg: f64, longitude_deg: f64, height_m: f64, date: Date) -> Result<[f64; 3], Failure> {
    let angle = |deg: f64| Angle::new::<degree>(deg as f32);
    let height = Length::new::<meter>(height_m as f32);
    let field = GeomagneticField::new(height, angle(latitude_deg), angle(longitude_deg), date)
        .map_err(|error| Failure::BadInput(format!("reference field: {error}")))?;
    Ok([field.x(), field.y(), field.z()].map(|x| f64::from(x.get::<microtesla>())))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::earth::reference_field::day;

    /// WMM2025 by pygeomag 1.1.0, an independent evaluation that takes any height: height in km, latitude, longitude,
    /// then total field in nT, dip and declination in degrees, on 2026-07-02 (2026.5).
    const INDEPENDENT: [(f64, f64, f64, f64, f64, f64); 6] = [
        (-5.0, 60.0, -2.0, 51339.01, 72.62627, -0.35878),
        (-12.0, 60.0, 2.0, 51563.30, 72.72299, 1.40575),
        (-3.0, 28.5, -90.0, 45306.72, 57.31948, -1.51495),
        (-8.0, 70.0, -150.0, 57230.81, 80.30404, 13.50171),
        (-10.0, -40.0, 145.0, 61280.67, -70.60045, 12.92863),
        (-2.0, 0.5, 120.0, 40957.64, -13.66653, -0.27732),
    ];

    #[test]
    fn the_field_at_depth_is_that_of_an_independent_evaluation() {
        let date = day("2026-07-02").unwrap();
        for (height_km, latitude, longitude, total_nt, dip_deg, declination_deg) in INDEPENDENT {
            let field = field_at(latitude, longitude, 1e3 * height_km, date).unwrap();
            let off_nt = f64::from(field.total_ut) * 1e3 - total_nt;
            let [dip, declination] = [field.dip_rad, field.declination_rad].map(|x| f64::from(x).to_degrees());
            assert!(off_nt.abs() < 0.3, "{height_km} {latitude}: {off_nt} nT");
            assert!(
                (dip - dip_deg).abs() < 5e-4 && (declination - declination_deg).abs() < 1e-3,
                "{dip} {declination}"
            );
        }
    }

    #[test]
    fn the_field_is_smooth_through_the_lowest_height_and_every_longitude_convention_is_the_same() {
        let date = day("2026-01-01").unwrap();
        let above = field_at(60.0, -2.0, -999.0, date).unwrap();
        let below = field_at(60.0, -2.0, -1_001.0, date).unwrap();
        assert!((above.total_ut - below.total_ut).abs() < 2e-4, "{above:?} {below:?}");
        for longitude in [358.0, -362.0, 718.0] {
            assert_eq!(field_at(60.0, longitude, -5_000.0, date), field_at(60.0, -2.0, -5_000.0, date));
        }
        // 5 km down a field of 50 microtesla is stronger by some 115 nT.
        let deeper =
            field_at(60.0, -2.0, -5_000.0, date).unwrap().total_ut - field_at(60.0, -2.0, 0.0, date).unwrap().total_ut;
        assert!((0.09..0.14).contains(&deeper), "{deeper}");
        for height in [-12_001.0, f64::NAN] {
            assert!(field_at(60.0, 0.0, height, date).is_err());
        }
        for (latitude, longitude) in [(97.8, 2.0), (57.8, f64::NAN)] {
            let told = field_at(latitude, longitude, 0.0, date).unwrap_err().to_string();
            assert!(
                told.contains(&format!("latitude {latitude}, longitude {longitude}: must be from -90 to 90")),
                "{told}"
            );
        }
    }
}
