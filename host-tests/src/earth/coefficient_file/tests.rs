#![allow(clippy::unwrap_used)]
use std::fmt::Write;

use nalgebra::Vector3;

use super::*;
use crate::earth::reference_field::{day, reference_field};

/// WMM2025 as the National Centers for Environmental Information publish it: a work of the United States government,
/// in the public domain.
const WMM2025: &str = include_str!("WMM2025.COF");

/// Height in km, latitude, longitude, then north, east and down in nT, of WMM2025 and of WMMHR-2025.
type Row = (f64, f64, f64, [f64; 3], [f64; 3]);

/// At 2026.5, by pygeomag 1.1.0, which shares nothing with this.
const INDEPENDENT: [Row; 7] = [
    (-5.0, 60.0, -2.0, [15329.694, -95.993, 48996.789], [15305.666, -68.626, 49033.326]),
    (-12.0, 60.0, 2.0, [15309.268, 375.688, 49236.765], [15300.082, 320.388, 49211.708]),
    (-3.0, 28.5, -90.0, [24455.000, -646.761, 38134.408], [24496.886, -634.859, 38090.677]),
    (-8.0, 70.0, -150.0, [9372.416, 2250.414, 56413.287], [9328.737, 2215.565, 56389.393]),
    (-10.0, -40.0, 145.0, [19838.604, 4554.082, -57801.478], [19861.278, 4527.204, -57796.437]),
    (-2.0, 0.5, 120.0, [39797.552, -192.626, -9677.088], [39781.423, -185.561, -9696.790]),
    (0.0, -80.0, 240.0, [6167.457, 15738.936, -51879.199], [6185.600, 15727.881, -51955.134]),
];

fn worst_nt(model: &CoefficientFile, pick: impl Fn(&Row) -> [f64; 3]) -> f64 {
    let off = INDEPENDENT.iter().flat_map(|row| {
        let (height_km, latitude, longitude, ..) = *row;
        let field = model.components(latitude.to_radians(), longitude.to_radians(), 1e3 * height_km, 1.5);
        let told = [field.north_nt, field.east_nt, field.down_nt];
        std::array::from_fn::<f64, 3, _>(|k| (told[k] - pick(row)[k]).abs())
    });
    off.fold(0.0, f64::max)
}

#[test]
fn the_file_of_wmm2025_gives_the_model_at_depth() {
    let model = CoefficientFile::parse(WMM2025).unwrap();
    assert_eq!((model.name.as_str(), model.epoch, model.degree), ("WMM-2025", 2025.0, 12));
    let worst = worst_nt(&model, |row| row.3);
    println!("largest difference from pygeomag: {worst:.4} nT");
    assert!(worst < 1e-3, "{worst} nT");
}

#[test]
fn the_file_of_wmm2025_gives_what_the_built_in_model_gives() {
    let model = CoefficientFile::parse(WMM2025).unwrap();
    let date = day("2027-03-09").unwrap();
    for latitude in [-90.0, -89.0, -45.0, 0.0, 30.0, 89.9, 90.0] {
        for longitude in [-170.0, 0.0, 100.0, 359.0] {
            let field = model.field_at(latitude, longitude, 500.0, date).unwrap();
            let longitude = if longitude > 180.0 { longitude - 360.0 } else { longitude };
            let built_in = reference_field(latitude, longitude, 500.0, date).unwrap();
            // In single precision; at a pole itself declination is a convention.
            assert!((field.total_nt() - 1e3 * f64::from(built_in.total_ut)).abs() < 0.3, "{latitude} {longitude}");
            assert!(
                (field.dip_deg() - f64::from(built_in.dip_rad).to_degrees()).abs() < 1e-3,
                "{latitude} {longitude}"
            );
            let off = field.declination_deg() - f64::from(built_in.declination_rad).to_degrees();
            assert!(latitude.abs() > 89.0 || libm::remainder(off, 360.0).abs() < 2e-3, "{latitude} {longitude}: {off}");
        }
    }
}

/// The field of a point pole in the earth is known in closed form, and its coefficients are Legendre functions at its
/// place, so that degree 133 is tested against no harmonic at all.
#[test]
fn degree_133_is_the_field_of_a_buried_pole() {
    const DEGREE: usize = 133;
    let (depth, theta, lambda, strength_nt) = (0.78 * SPHERE_M, 0.9, 2.1, 30_000.0);
    let (p, _) = legendre(DEGREE, libm::sin(theta), libm::cos(theta));
    let mut text = "2025.0 POLE 01/01/2025\n".to_owned();
    for n in 1..=DEGREE {
        for m in 0..=n {
            let size = strength_nt * (depth / SPHERE_M).powi(n as i32) * p[place(n, m)];
            let (s, c) = libm::sincos(m as f64 * lambda);
            writeln!(text, "{n} {m} {:e} {:e} 0.0 0.0", size * c, size * s).unwrap();
        }
    }
    text.push_str("999999999999\n");
    let model = CoefficientFile::parse(&text).unwrap();
    let spherical = |r: f64, theta: f64, lambda: f64| {
        let (s, c) = libm::sincos(theta);
        r * Vector3::new(s * libm::cos(lambda), s * libm::sin(lambda), c)
    };
    let pole = spherical(depth, theta, lambda);
    let mut largest: f64 = 0.0;
    for (latitude, longitude, height) in
        [(38.0_f64, 120.0_f64, -12e3), (45.0, 110.0, 0.0), (-60.0, 300.0, 5e3), (89.0, 10.0, -3e3), (0.0, 0.0, 8e5)]
    {
        let (lat, lon) = (latitude.to_radians(), longitude.to_radians());
        let (axis, e2) = WGS84;
        let curvature = axis / libm::sqrt(1.0 - e2 * libm::sin(lat) * libm::sin(lat));
        let from_axis = (curvature + height) * libm::cos(lat);
        let at = Vector3::new(
            from_axis * libm::cos(lon),
            from_axis * libm::sin(lon),
            (curvature * (1.0 - e2) + height) * libm::sin(lat),
        );
        let of = |d: Vector3<f64>| d / libm::pow(d.norm(), 3.0);
        let field = strength_nt * SPHERE_M * SPHERE_M * (of(at - pole) - of(at));
        let up = Vector3::new(libm::cos(lat) * libm::cos(lon), libm::cos(lat) * libm::sin(lon), libm::sin(lat));
        let east = Vector3::new(-libm::sin(lon), libm::cos(lon), 0.0);
        let expected = [field.dot(&up.cross(&east)), field.dot(&east), -field.dot(&up)];
        let told = model.components(lat, lon, height, 0.0);
        for (told, expected) in [told.north_nt, told.east_nt, told.down_nt].into_iter().zip(expected) {
            largest = largest.max((told - expected).abs() / field.norm());
        }
    }
    println!("largest difference from the closed form: {largest:.1e} of the field");
    assert!(largest < 1e-8, "{largest}");
}

#[test]
#[ignore = "needs WMMHR_2025.COF of the National Centers for Environmental Information, named by MWD_WMMHR"]
fn the_high_resolution_model_is_that_of_an_independent_evaluation() {
    let path = std::env::var("MWD_WMMHR").unwrap();
    let model = CoefficientFile::read(Path::new(&path)).unwrap();
    assert_eq!((model.name.as_str(), model.degree), ("WMMHR-2025", 133));
    let worst = worst_nt(&model, |row| row.4);
    println!("largest difference from pygeomag: {worst:.4} nT");
    assert!(worst < 1e-3, "{worst} nT");
}

#[test]
fn what_is_no_file_of_coefficients_is_refused_with_its_line() {
    let file = |body: &str| format!("2025.0 X 01/01/2025\n{body}\n9999\n");
    for (text, said) in [
        (String::new(), "empty"),
        ("WMM 2025\n".to_owned(), "line 1"),
        (file(""), "no coefficients"),
        (file("1 0 1 0 0 0"), "lacks degree 1, order 1"),
        (file("1 0 1 0 0 0\n1 1 1 0 0 0\n1 1 2 0 0 0"), "line 4: degree 1, order 1 stands there twice"),
        (file("1 2 1 0 0 0"), "line 2: degree 1, order 2"),
        (file("999 2 1 0 0 0"), "line 2"),
        (file("1 0 NaN 0 0 0"), "line 2: \"NaN\" is no number"),
        (file("1 0 1 0 0"), "line 2"),
    ] {
        let error = CoefficientFile::parse(&text).unwrap_err();
        assert!(error.contains(said), "{text:?}: {error}");
    }
    let model = CoefficientFile::parse(WMM2025).unwrap();
    let date = day("2026-01-01").unwrap();
    for (latitude, height) in [(91.0, 0.0), (60.0, -12_001.0), (60.0, 9e5), (f64::NAN, 0.0), (60.0, f64::NAN)] {
        assert!(model.field_at(latitude, 0.0, height, date).is_err(), "{latitude} {height}");
    }
    assert!(model.field_at(60.0, 0.0, 0.0, day("2031-01-01").unwrap()).is_err());
}
