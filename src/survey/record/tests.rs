use super::*;
use nalgebra::{Matrix3, Vector3};

#[test]
fn the_offset_is_added_to_both_toolfaces_and_the_switch_has_hysteresis() {
    let covariance = SixAxisCovariance { gravity: Matrix3::identity() * 1e-5, field: Matrix3::identity() * 1e-3 };
    let config = SurveyConfig { toolface_offset_rad: 350.0_f32.to_radians(), ..SurveyConfig::default() };
    let mut switch = ToolfaceSwitch::new();
    let mut taken = |inclination_deg: f32| {
        let (s, c) = libm::sincosf(inclination_deg.to_radians());
        // Toolface 0 and azimuth 0: gravity towards -x, field in the same plane.
        let (g, b) =
            (Vector3::new(-9.8 * s, 0.0, 9.8 * c), Vector3::new(20.0 * c - 45.0 * s, 0.0, 20.0 * s + 45.0 * c));
        let six = SixAxis::of(&g, Some(&b)).unwrap();
        let settings = (&Earth::default(), &config);
        Survey::of_six_axis(SurveyKind::Stationary, [0, 1], &six, &covariance, &mut switch, settings)
    };
    let degrees = |x: Option<Uncertain>| x.unwrap().value.to_degrees();
    let survey = taken(30.0);
    assert!((degrees(survey.gravity_toolface_rad) - 350.0).abs() < 1e-3);
    assert!((degrees(survey.magnetic_toolface_rad) - 350.0).abs() < 1e-3);
    let kinds = [6.0, 5.2, 4.9, 5.2, 5.6, 5.2].map(|inclination| taken(inclination).toolface_kind);
    use ToolfaceKind::{Gravity, Magnetic};
    assert_eq!(kinds, [Gravity, Gravity, Magnetic, Magnetic, Gravity, Gravity]);
    assert_eq!(taken(3.0).toolface_rad(), taken(3.0).magnetic_toolface_rad);
}
