//! Continuous surveys have the filter's angles and deviations.

use super::*;
use crate::rotation::{exp_quaternion, matrix, rotate_back};
use core::f32::consts::FRAC_PI_2;
use nalgebra::Matrix3;

/// Attitude as the filter states it for a covariance with equal tilt in both directions.
fn attitude(azimuth: f32, inclination: f32, toolface: f32, near_vertical: bool) -> (Attitude, ToolAngleSigmas) {
    stated([4e-6, 4e-6, 1e-4], [azimuth, inclination, toolface], near_vertical)
}

/// Attitude as the filter states it for these variances about north, east and down, rad^2.
fn stated(
    variances: [f32; 3],
    [azimuth, inclination, toolface]: [f32; 3],
    near_vertical: bool,
) -> (Attitude, ToolAngleSigmas) {
    let about = |x: f32, y: f32, z: f32| exp_quaternion(&Vector3::new(x, y, z));
    let q = about(0.0, 0.0, azimuth) * about(0.0, inclination, 0.0) * about(0.0, 0.0, toolface);
    let covariance = Matrix3::from_diagonal(&Vector3::from(variances));
    let (angles, sigmas) = (ToolAngles::of(&matrix(&q)), ToolAngleSigmas::of(&matrix(&q), &covariance));
    let mut flags = AttitudeFlags::empty();
    flags.set(AttitudeFlags::NEAR_VERTICAL, near_vertical);
    let attitude = Attitude {
        q: [q.w, q.i, q.j, q.k],
        inclination_rad: angles.inclination_rad,
        azimuth_rad: angles.azimuth_rad,
        gravity_toolface_rad: angles.gravity_toolface_rad,
        magnetic_toolface_rad: angles.magnetic_toolface_rad,
        sigma_inclination_rad: sigmas.inclination_rad,
        sigma_azimuth_rad: sigmas.azimuth_rad,
        sigma_toolface_rad: if near_vertical { sigmas.magnetic_toolface_rad } else { sigmas.gravity_toolface_rad },
        flags,
    };
    (attitude, sigmas)
}

#[test]
fn both_toolface_sigmas_are_those_of_the_filters_covariance() {
    for inclination in [0.02_f32, 0.06, 0.2, 1.0, 1.57, 2.5] {
        for near_vertical in [false, true] {
            let (attitude, sigmas) = attitude(1.0, inclination, 2.0, near_vertical);
            let known = angles(&attitude, 20.0, &Earth::default());
            for (got, want) in [
                (known.sigmas.gravity_toolface_rad, sigmas.gravity_toolface_rad),
                (known.sigmas.magnetic_toolface_rad, sigmas.magnetic_toolface_rad),
            ] {
                assert!((got / want - 1.0).abs() < 0.01, "{inclination} {near_vertical}: {got} {want}");
            }
        }
    }
}

/// A hole to the east, whose tilt is uncertain about north alone: inclination does not show it, and azimuth does.
#[test]
fn a_magnetic_toolface_is_not_surer_than_the_heading_where_the_tilts_differ() {
    for [north, east] in [[2.5e-3, 1e-6], [1e-6, 2.5e-3]] {
        let (attitude, sigmas) = stated([north, east, 2.7e-3], [FRAC_PI_2, 0.35, 0.0], false);
        let ours = angles(&attitude, 20.0, &Earth::default()).sigmas.magnetic_toolface_rad;
        assert!(ours > 0.9 * sigmas.magnetic_toolface_rad, "{ours} {}", sigmas.magnetic_toolface_rad);
    }
}

#[test]
fn magnetic_and_true_azimuth_come_apart_again_and_totals_are_the_fields() {
    let earth = Earth { declination_rad: Some(0.1), ..Earth::default() };
    let config = SurveyConfig::default();
    // the filter's azimuth is true when it knows a declination
    let (attitude, _) = attitude(0.05, 0.8, 2.0, false);
    let [w, x, y, z] = attitude.q;
    let q = Quaternion::new(w, x, y, z);
    let north = Vector3::new(20.0 * libm::cosf(0.1), 20.0 * libm::sinf(0.1), 45.0);
    let mut continuous = Continuous::new();
    for k in 0..400_u32 {
        let shake = if k % 2 == 0 { 0.3 } else { -0.3 };
        let input = SurveyInput {
            t_us: u64::from(k) * 5_000,
            force_m_s2: Some(rotate_back(&q, &Vector3::new(0.0, 0.0, -9.8 + shake)).into()),
            field_ut: Some(rotate_back(&q, &north).into()),
            temperature_c: Some(90.0),
            attitude: Some(attitude),
            ..SurveyInput::default()
        };
        continuous.push(&input, 0.005);
    }
    let survey = continuous.survey(ToolfaceSwitch::new(), true, (&earth, &config)).unwrap();
    let value = |x: Option<Uncertain>| x.unwrap().value;
    assert!((value(survey.true_azimuth_rad) - 0.05).abs() < 1e-5);
    assert!((value(survey.magnetic_azimuth_rad) - (0.05 - 0.1 + TAU)).abs() < 1e-5);
    assert!((value(survey.gravity_m_s2) - 9.8).abs() < 0.01);
    assert!((survey.gravity_m_s2.unwrap().sigma - 0.3).abs() < 0.02, "shaking is in the sigma");
    assert!((value(survey.field_ut) - libm::hypotf(20.0, 45.0)).abs() < 1e-3);
    assert!((value(survey.dip_rad) - libm::atan2f(45.0, 20.0)).abs() < 1e-5);
    assert_eq!((survey.temperature_c, survey.rotating, survey.kind), (Some(90.0), true, SurveyKind::Continuous));
    let declination = libm::hypotf(0.36, 5_000.0 / 20_000.0).to_radians();
    let sigma = libm::hypotf(attitude.sigma_azimuth_rad, declination);
    assert!((survey.true_azimuth_rad.unwrap().sigma / sigma - 1.0).abs() < 1e-3);
}

/// Before a field has given the heading, the filter counts it from somewhere: no azimuth is told, from no north, and no
/// magnetic toolface.
#[test]
fn a_heading_that_no_field_has_given_is_not_told() {
    let (earth, config) = (Earth { declination_rad: Some(0.1), ..Earth::default() }, SurveyConfig::default());
    for (inclination, near_vertical) in [(0.8, false), (0.02, true)] {
        for is_known in [true, false] {
            let (mut attitude, _) = attitude(0.05, inclination, 2.0, near_vertical);
            attitude.flags.set(AttitudeFlags::NO_HEADING, !is_known);
            let mut continuous = Continuous::new();
            for k in 0..400_u64 {
                let force_m_s2 = Some([0.0, 0.0, -9.8]);
                let input =
                    SurveyInput { t_us: k * 5_000, force_m_s2, attitude: Some(attitude), ..SurveyInput::default() };
                continuous.push(&input, 0.005);
            }
            let survey = continuous.survey(ToolfaceSwitch::new(), false, (&earth, &config)).unwrap();
            let told = [survey.magnetic_azimuth_rad, survey.true_azimuth_rad].map(|azimuth| azimuth.is_some());
            assert_eq!(told, [is_known; 2], "{inclination}");
        }
    }
}

#[test]
fn what_is_no_longer_read_is_no_longer_told() {
    let (earth, config) = (Earth::default(), SurveyConfig::default());
    let (attitude, _) = attitude(0.05, 0.8, 2.0, false);
    let mut continuous = Continuous::new();
    let mut told_s = [0.0; 3];
    for k in 0..4_000_u32 {
        let t_s = k as f32 * 0.005;
        // The field is read 8 times a second for 10 s, the force for 5 s.
        let force_m_s2 = (t_s < 5.0).then_some([0.0, -7.0, -6.86]);
        let field_ut = (t_s < 10.0 && k % 25 == 0).then_some([20.0, 4.0, 42.0]);
        let (t_us, attitude) = (u64::from(k) * 5_000, Some(attitude));
        continuous.push(&SurveyInput { t_us, force_m_s2, field_ut, attitude, ..SurveyInput::default() }, 0.005);
        let survey = continuous.survey(ToolfaceSwitch::new(), false, (&earth, &config)).unwrap();
        let told = [survey.gravity_m_s2, survey.field_ut, survey.dip_rad];
        told_s.iter_mut().zip(told).for_each(|(time_s, told)| *time_s += if told.is_some() { 0.005 } else { 0.0 });
    }
    for (told_s, read_s) in told_s.into_iter().zip([5.0, 10.0, 10.0]) {
        assert!((read_s..read_s + 1.01).contains(&told_s), "{told_s} {read_s}");
    }
}
