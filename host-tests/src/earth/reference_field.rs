//! The earth's magnetic field at a place and a date, by the World Magnetic Model.

use world_magnetic_model::{
    GeomagneticField,
    time::{Date, Month},
    uom::si::{
        angle::{degree, radian},
        f32::{Angle, Length},
        length::meter,
        magnetic_flux_density::microtesla,
    },
};

use testbed::failure::Failure;

/// The field of the World Magnetic Model, with that model's 1-sigma uncertainties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceField {
    /// Total field, microtesla.
    pub total_ut: f32,
    /// Its uncertainty, microtesla.
    pub total_sigma_ut: f32,
    /// Dip below the horizon, radians.
    pub dip_rad: f32,
    /// Its uncertainty, radians.
    pub dip_sigma_rad: f32,
    /// Declination east of true north, radians.
    pub declination_rad: f32,
    /// Its uncertainty, radians.
    pub declination_sigma_rad: f32,
}

/// The field at a geodetic latitude (degrees north), a longitude (degrees east), a height above the ellipsoid
/// (metres) and a day.
///
/// # Errors
/// A place or a day outside the model: 2020 to 2029, 1 km below the ellipsoid to 850 km above.
pub fn reference_field(
    latitude_deg: f64,
    longitude_deg: f64,
    height_m: f64,
    date: Date,
) -> Result<ReferenceField, Failure> {
    let angle = |deg: f64| Angle::new::<degree>(deg as f32);
    let field =
        GeomagneticField::new(Length::new::<meter>(height_m as f32), angle(latitude_deg), angle(longitude_deg), date)
            .map_err(|error| Failure::BadInput(format!("reference field: {error}")))?;
    Ok(ReferenceField {
        total_ut: field.f().get::<microtesla>(),
        total_sigma_ut: field.f_uncertainty().get::<microtesla>(),
        dip_rad: field.inclination().get::<radian>(),
        dip_sigma_rad: field.inclination_uncertainty().get::<radian>(),
        declination_rad: field.declination().get::<radian>(),
        declination_sigma_rad: field.declination_uncertainty().get::<radian>(),
    })
}

/// A day written as `YYYY-MM-DD`.
///
/// # Errors
/// Why the text is no day.
pub fn day(text: &str) -> Result<Date, String> {
    let mut parts = text.split('-');
    let (Some(year), Some(month), Some(day), None) = (parts.next(), parts.next(), parts.next(), parts.next()) else {
        return Err("must be YYYY-MM-DD".to_owned());
    };
    let date = || {
        let month = Month::try_from(month.parse::<u8>().ok()?).ok()?;
        Date::from_calendar_date(year.parse().ok()?, month, day.parse().ok()?).ok()
    };
    date().ok_or_else(|| "must be a day, YYYY-MM-DD".to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// `WMM2025_TEST_VALUES.txt` of NOAA's National Centers for Environmental Information: day, height in km,
    /// latitude, longitude, then X, Y, Z in nanotesla and the declination in degrees. 2027.5 is 2 July, noon.
    const PUBLISHED: [(&str, [f64; 7]); 12] = [
        ("2025-01-01", [0.0, 80.0, 0.0, 6521.6, 145.9, 54791.5, 1.28]),
        ("2025-01-01", [0.0, 0.0, 120.0, 39677.8, -109.6, -10580.2, -0.16]),
        ("2025-01-01", [0.0, -80.0, -120.0, 6117.5, 15751.9, -52022.5, 68.78]),
        ("2025-01-01", [100.0, 80.0, 0.0, 6216.0, 92.4, 52598.8, 0.85]),
        ("2025-01-01", [100.0, 0.0, 120.0, 37688.6, -96.2, -10152.1, -0.15]),
        ("2025-01-01", [100.0, -80.0, -120.0, 5907.6, 14780.3, -49540.7, 68.21]),
        ("2027-07-02", [0.0, 80.0, 0.0, 6500.8, 294.5, 54869.4, 2.59]),
        ("2027-07-02", [0.0, 0.0, 120.0, 39701.6, -167.4, -10381.8, -0.24]),
        ("2027-07-02", [0.0, -80.0, -120.0, 6200.7, 15730.3, -51783.7, 68.49]),
        ("2027-07-02", [100.0, 80.0, 0.0, 6196.7, 233.8, 52670.5, 2.16]),
        ("2027-07-02", [100.0, 0.0, 120.0, 37711.5, -148.7, -9969.8, -0.23]),
        ("2027-07-02", [100.0, -80.0, -120.0, 5984.0, 14760.1, -49317.7, 67.93]),
    ];

    #[test]
    fn the_published_test_values_come_out() {
        for (date, [height_km, latitude, longitude, x, y, z, declination]) in PUBLISHED {
            let field = reference_field(latitude, longitude, 1e3 * height_km, day(date).unwrap()).unwrap();
            let horizontal = x.hypot(y);
            // 1 nT, 0.002 deg of dip; the declination is published to 0.01 deg
            assert!((f64::from(field.total_ut) * 1e3 - horizontal.hypot(z)).abs() < 1.0, "{date} {latitude} {field:?}");
            let dip = z.atan2(horizontal).to_degrees();
            assert!((f64::from(field.dip_rad).to_degrees() - dip).abs() < 0.002, "{date} {latitude} {field:?}");
            let off = f64::from(field.declination_rad).to_degrees() - declination;
            assert!(off.abs() < 0.008, "{date} {latitude} {off}");
        }
    }

    #[test]
    fn a_day_or_a_place_that_is_none_is_refused() {
        for text in ["2026-02-30", "2026", "2026-1-1-1", "yesterday", "2026-13-01"] {
            assert!(day(text).is_err(), "{text}");
        }
        assert!(reference_field(91.0, 0.0, 0.0, day("2026-01-01").unwrap()).is_err());
        assert!(reference_field(60.0, 0.0, 0.0, day("2031-01-01").unwrap()).is_err());
    }
}
