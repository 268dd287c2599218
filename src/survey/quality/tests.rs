//! Grades and their reasons, with and without references.

use super::*;
use crate::survey::{SurveyKind, ToolfaceKind};

fn survey(gravity: f32, field: Option<f32>, dip_deg: f32) -> Survey {
    let uncertain = |value, sigma| Uncertain { value, sigma };
    Survey {
        kind: SurveyKind::Stationary,
        t_start_us: 0,
        t_end_us: 1,
        inclination_rad: Uncertain::default(),
        magnetic_azimuth_rad: None,
        true_azimuth_rad: None,
        grid_azimuth_rad: None,
        gravity_toolface_rad: None,
        magnetic_toolface_rad: None,
        toolface_kind: ToolfaceKind::Gravity,
        gravity_m_s2: Some(uncertain(gravity, 0.006)),
        field_ut: field.map(|x| uncertain(x, 0.12)),
        dip_rad: field.map(|_| uncertain(dip_deg.to_radians(), 0.2_f32.to_radians())),
        temperature_c: None,
        rotating: false,
    }
}

const fn earth() -> Earth {
    Earth {
        gravity_m_s2: 9.8,
        magnetic_field_ut: Some(50.0),
        dip_rad: Some(70.0_f32.to_radians()),
        declination_rad: None,
        latitude_rad: None,
    }
}

#[test]
fn the_grade_and_its_reason_follow_the_check_that_is_furthest_off() {
    let config = SurveyConfig::default();
    let judged = |gravity, field, dip| {
        let quality = Quality::of(&survey(gravity, field, dip), &earth(), &config);
        (quality.grade, quality.reason.checked, quality.reason.difference)
    };
    assert_eq!(judged(9.80, Some(50.25), 70.1).0, Grade::Good);
    let (grade, checked, difference) = judged(9.80, Some(50.4), 70.1);
    assert_eq!((grade, checked), (Grade::Doubtful, Checked::Field));
    assert!((difference.unwrap() - 0.4).abs() < 1e-5);
    assert_eq!(judged(9.80, Some(49.5), 70.1).0, Grade::Bad);
    let (grade, checked, difference) = judged(9.80, Some(50.4), 69.6);
    assert_eq!((grade, checked), (Grade::Bad, Checked::Dip));
    assert!((difference.unwrap().to_degrees() + 0.4).abs() < 1e-3);
    assert_eq!(judged(9.83, Some(50.0), 70.0).1, Checked::Gravity);
    assert_eq!(judged(9.80, None, 70.0).0, Grade::Bad);
}

#[test]
fn without_a_reference_a_check_is_not_made() {
    let earth = Earth { magnetic_field_ut: None, dip_rad: None, ..earth() };
    let quality = Quality::of(&survey(9.8, Some(80.0), 10.0), &earth, &SurveyConfig::default());
    assert_eq!((quality.grade, quality.field, quality.dip), (Grade::Good, None, None));
}

#[test]
fn propagated_limits_are_deviations_of_measurement_and_reference() {
    let mut config = SurveyConfig::default();
    let measured = survey(9.81, Some(50.4), 70.0);
    let rotating = Quality::of(&Survey { kind: SurveyKind::Rotating, ..measured }, &earth(), &config);
    config.limits.propagated = true;
    let quality = Quality::of(&measured, &earth(), &config);
    assert_eq!(rotating, quality);
    assert!((quality.field.unwrap().limit - 2.0 * libm::hypotf(0.12, 0.13)).abs() < 1e-6);
    assert!((quality.gravity.limit - 0.012).abs() < 1e-6);
    assert!((quality.dip.unwrap().limit.to_degrees() - 2.0 * libm::hypotf(0.2, 0.2)).abs() < 1e-5);
    assert_eq!(quality.reason.checked, Checked::Field);
    assert_eq!(quality.grade, Grade::Doubtful);
}

#[test]
fn a_reference_that_is_no_number_is_bad_and_is_not_configured() {
    let config = SurveyConfig::default();
    for (field, earth) in [
        ("earth.dip_rad", Earth { dip_rad: Some(f32::NAN), ..earth() }),
        ("earth.magnetic_field_ut", Earth { magnetic_field_ut: Some(f32::NAN), ..earth() }),
        // In nanotesla.
        ("earth.magnetic_field_ut", Earth { magnetic_field_ut: Some(50_480.0), ..earth() }),
        ("earth.gravity_m_s2", Earth { gravity_m_s2: f32::NAN, ..earth() }),
    ] {
        assert_eq!(Quality::of(&survey(9.8, Some(50.0), 70.0), &earth, &config).grade, Grade::Bad, "{field}");
        let refused = crate::survey::Surveys::new().configure(&earth, &config).map_err(|error| error.field);
        assert_eq!(refused, Err(field));
    }
}
