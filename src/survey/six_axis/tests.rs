//! Angles and their deviations from mean vectors, against the textbook, the ISCWSA weighting functions and finite
//! differences.

extern crate std;

use super::*;
use crate::{config::SurveyErrors, survey::sensor_errors};

const TAU: f64 = core::f64::consts::TAU;

/// Ideal mean vectors of a tool at azimuth a, inclination i, toolface t: gravity and field turned from NED by
/// azimuth about down, then by inclination about the new y axis, then by toolface about the tool axis.
fn ideal(a: f64, i: f64, t: f64, total_ut: f64, dip: f64) -> ([f64; 3], [f64; 3]) {
    let into_tool = |v: [f64; 3]| {
        let about_z = |v: [f64; 3], angle: f64| {
            let (s, c) = libm::sincos(angle);
            [c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]]
        };
        let about_y = |v: [f64; 3], angle: f64| {
            let (s, c) = libm::sincos(angle);
            [c * v[0] - s * v[2], v[1], c * v[2] + s * v[0]]
        };
        about_z(about_y(about_z(v, a), i), t)
    };
    let (s, c) = libm::sincos(dip);
    (into_tool([0.0, 0.0, 9.81]), into_tool([total_ut * c, 0.0, total_ut * s]))
}

fn single(v: [f64; 3]) -> Vector3<f32> {
    Vector3::from(v.map(|x| x as f32))
}

fn apart(a: f64, b: f64) -> f64 {
    libm::fabs(libm::remainder(a - b, TAU))
}

/// Textbook formulas by components in f64: azimuth (six-axis), inclination, gravity toolface, dip.
fn textbook(g: [f64; 3], b: [f64; 3]) -> [f64; 4] {
    let norm = |v: [f64; 3]| libm::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    let dot = g[0] * b[0] + g[1] * b[1] + g[2] * b[2];
    [
        libm::atan2(
            (g[0] * b[1] - g[1] * b[0]) * norm(g),
            b[2] * (g[0] * g[0] + g[1] * g[1]) - g[2] * (g[0] * b[0] + g[1] * b[1]),
        ),
        libm::atan2(libm::hypot(g[0], g[1]), g[2]),
        libm::atan2(g[1], -g[0]),
        libm::asin(dot / (norm(g) * norm(b))),
    ]
}

#[test]
fn angles_and_totals_agree_with_the_textbook_in_all_quadrants() {
    let mut worst = 0.0_f64;
    for dip_deg in [58.0, -70.0, 0.0, 80.0_f64] {
        for i_deg in [2, 10, 45, 89, 90, 91, 135, 170, 178] {
            for a_deg in (0..360).step_by(15) {
                for t_deg in (0..360).step_by(15) {
                    let [i, a, t] = [i_deg, a_deg, t_deg].map(|d| f64::from(d).to_radians());
                    let (g, b) = ideal(a, i, t, 48.0, dip_deg.to_radians());
                    let six = SixAxis::of(&single(g), Some(&single(b))).unwrap();
                    // The textbook gets the same rounded vectors, so that only the formulas are compared.
                    let exact = textbook(single(g).map(f64::from).into(), single(b).map(f64::from).into());
                    let angles = six.angles();
                    let field = six.field().unwrap();
                    for (got, want, truth) in [
                        (angles.azimuth_rad, exact[0], a),
                        (angles.inclination_rad, exact[1], i),
                        (angles.gravity_toolface_rad, exact[2], t),
                        (field.dip_rad, exact[3], dip_deg.to_radians()),
                    ] {
                        worst = worst.max(apart(got.into(), want));
                        assert!(apart(want, truth) < 2e-5, "{a_deg} {i_deg} {t_deg} {want} {truth}");
                    }
                    if i_deg < 170 {
                        worst = worst.max(apart(angles.magnetic_toolface_rad.into(), exact[0] + exact[2]));
                    }
                    assert!((f64::from(six.gravity_m_s2()) - 9.81).abs() < 1e-5);
                    assert!((f64::from(field.total_ut) - 48.0).abs() < 5e-5);
                    assert!((f64::from(field.horizontal_ut) - 48.0 * libm::cos(dip_deg.to_radians())).abs() < 5e-5);
                }
            }
        }
    }
    std::println!("largest difference from the textbook {worst:.1e} rad");
    assert!(worst < 1e-5, "{worst}");
}

#[test]
fn along_the_vertical_what_is_defined_is_exact() {
    for turn_deg in (0..360).step_by(5) {
        let turn = f64::from(turn_deg).to_radians();
        // Down: azimuth and toolface are one turn, and its division between the two is undefined.
        for (a, t) in [(turn, 0.0), (0.0, turn), (0.4 * turn, 0.6 * turn)] {
            let (g, b) = ideal(a, 0.0, t, 50.0, 1.2);
            let angles = SixAxis::of(&single(g), Some(&single(b))).unwrap().angles();
            assert_eq!(angles.inclination_rad, 0.0);
            assert!(apart(angles.magnetic_toolface_rad.into(), turn) < 1e-5);
        }
        // Up: the difference is one turn, and everything is finite.
        let (g, b) = ideal(turn, core::f64::consts::PI, 0.0, 50.0, 1.2);
        let six = SixAxis::of(&single(g), Some(&single(b))).unwrap();
        let angles = six.angles();
        assert!(apart(angles.inclination_rad.into(), core::f64::consts::PI) < 1e-5);
        assert!(angles.azimuth_rad.is_finite() && angles.magnetic_toolface_rad.is_finite());
        let sigmas = six.angle_sigmas(&covariance(&single(g), &single(b), &SurveyErrors::default()));
        assert!(sigmas.azimuth_rad <= PI && sigmas.inclination_rad < 1e-3);
    }
}

#[test]
fn without_a_usable_field_inclination_and_gravity_toolface_stay() {
    let (g, _) = ideal(1.0, 0.8, 2.0, 50.0, 1.2);
    let down = single(g);
    for field in [None, Some(down * 5.0), Some(Vector3::zeros()), Some(Vector3::new(f32::NAN, 1.0, 1.0))] {
        let six = SixAxis::of(&down, field.as_ref()).unwrap();
        let angles = six.angles();
        assert!(apart(angles.inclination_rad.into(), 0.8) < 1e-5 && six.field().is_none());
        assert!(apart(angles.gravity_toolface_rad.into(), 2.0) < 1e-5);
    }
    for none in [Vector3::zeros(), Vector3::new(f32::NAN, 0.0, 9.8), Vector3::new(f32::INFINITY, 0.0, 9.8)] {
        assert!(SixAxis::of(&none, None).is_none());
    }
}

fn covariance(g: &Vector3<f32>, b: &Vector3<f32>, errors: &SurveyErrors) -> SixAxisCovariance {
    SixAxisCovariance {
        gravity: sensor_errors::gravity_covariance(g, errors),
        field: sensor_errors::field_covariance(b, errors),
    }
}

/// Variances of azimuth and inclination by the weighting functions of the ISCWSA MWD error model for a
/// sliding tool at any toolface, as in the public implementation `welleng` (revision 4).
fn iscwsa_variances(i: f64, a: f64, dip: f64, total_ut: f64, e: &SurveyErrors) -> [f64; 2] {
    let ((si, ci), (sa, ca), tan) = (libm::sincos(i), libm::sincos(a), libm::tan(dip));
    let (g, horizontal) = (9.81, total_ut * libm::cos(dip));
    let [ab, asc, mb, ms, amil] =
        [e.accel_bias_m_s2, e.accel_scale, e.mag_bias_ut, e.mag_scale, e.axial_interference_ut].map(f64::from);
    let half = core::f64::consts::FRAC_1_SQRT_2;
    // Magnitude, weight of inclination, weight of azimuth.
    let terms = [
        (ab, -ci / g, ci * tan * sa / g),
        (ab, 0.0, (ci / si - tan * ca) / g),
        (ab, -si / g, si * tan * sa / g),
        (asc, si * ci * half, -si * tan * ci * sa * half),
        (asc, si * ci / 2.0, -si * tan * ci * sa / 2.0),
        (asc, 0.0, (si * tan * ca - ci) / 2.0),
        (asc, -si * ci, si * tan * ci * sa),
        (mb, 0.0, -ci * sa / horizontal),
        (mb, 0.0, ca / horizontal),
        (mb, 0.0, -si * sa / horizontal),
        (ms, 0.0, si * sa * (tan * ci + si * ca) * half),
        (ms, 0.0, sa * (tan * si * ci - ci * ci * ca - ca) / 2.0),
        (ms, 0.0, (ci * ca * ca - ci * sa * sa - tan * si * ca) / 2.0),
        (ms, 0.0, -(si * ca + tan * ci) * si * sa),
        (amil, 0.0, -si * sa / horizontal),
    ];
    let mut variances = [0.0; 2];
    for (magnitude, of_inclination, of_azimuth) in terms {
        variances[0] += libm::pow(magnitude * of_inclination, 2.0);
        variances[1] += libm::pow(magnitude * of_azimuth, 2.0);
    }
    variances
}

#[test]
fn sigmas_averaged_over_toolfaces_are_those_of_the_iscwsa_weighting_functions() {
    let errors = SurveyErrors::default();
    for dip in [1.01, -1.22, 0.3_f64] {
        for i in [0.1, 0.5, 1.2, core::f64::consts::FRAC_PI_2, 2.4_f64] {
            for a in [0.0, 0.7, 1.5, 2.6, 3.9, 5.5_f64] {
                let mut sums = [0.0_f64; 2];
                let toolfaces = 24;
                for k in 0..toolfaces {
                    let (g, b) = ideal(a, i, TAU * f64::from(k) / f64::from(toolfaces), 50.0, dip);
                    let (g, b) = (single(g), single(b));
                    let sigmas = SixAxis::of(&g, Some(&b)).unwrap().angle_sigmas(&covariance(&g, &b, &errors));
                    for (sum, sigma) in sums.iter_mut().zip([sigmas.inclination_rad, sigmas.azimuth_rad]) {
                        *sum += f64::from(sigma) * f64::from(sigma) / f64::from(toolfaces);
                    }
                }
                let published = iscwsa_variances(i, a, dip, 50.0, &errors);
                for (sum, published) in sums.iter().zip(published) {
                    assert!((sum / published - 1.0).abs() < 2e-3, "dip {dip} i {i} a {a}: {sum:e} {published:e}");
                }
            }
        }
    }
}

#[test]
fn every_sigma_is_the_finite_difference_of_its_quantity() {
    let h = 2e-3_f64;
    for (a, i, t, dip) in [(0.3, 0.2, 1.0, 1.0), (2.5, 1.3, 4.0, -1.2), (5.9, 2.6, 6.0, 0.2), (4.0, 1.57, 3.0, 1.25)] {
        let (g, b) = ideal(a, i, t, 50.0, dip);
        let six = SixAxis::of(&single(g), Some(&single(b))).unwrap();
        for axis in 0..6 {
            // Axes of gravity in m/s^2, then of the field in microtesla.
            let moved = |step: f64| {
                let (mut g, mut b) = (g, b);
                if axis < 3 {
                    g[axis] += step
                } else {
                    b[axis - 3] += step
                }
                let [azimuth, inclination, toolface, dip] = textbook(g, b);
                let norm = |v: [f64; 3]| libm::sqrt(v.iter().map(|x| x * x).sum());
                [azimuth, inclination, toolface, azimuth + toolface, dip, norm(g), norm(b)]
            };
            let (plus, minus) = (moved(h), moved(-h));
            let mut covariance = SixAxisCovariance { gravity: Matrix3::zeros(), field: Matrix3::zeros() };
            let which = if axis < 3 { &mut covariance.gravity } else { &mut covariance.field };
            which[(axis % 3, axis % 3)] = 1.0;
            let s = six.angle_sigmas(&covariance);
            let (total, dip_sigma) = six.field_sigmas(&covariance).unwrap();
            let stated = [
                s.azimuth_rad,
                s.inclination_rad,
                s.gravity_toolface_rad,
                s.magnetic_toolface_rad,
                dip_sigma,
                six.gravity_sigma_m_s2(&covariance),
                total,
            ];
            for (k, stated) in stated.into_iter().enumerate() {
                let difference = if k < 5 { apart(plus[k], minus[k]) } else { (plus[k] - minus[k]).abs() } / (2.0 * h);
                let off = (difference - f64::from(stated)).abs();
                assert!(off < 2e-3 * difference + 5e-5, "axis {axis} quantity {k}: {difference} {stated}");
            }
        }
    }
}
