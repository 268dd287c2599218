use super::*;
use nalgebra::Matrix3;

fn after(rate: impl Fn(f32) -> f32) -> SustainedRotation {
    let mut rotation = SustainedRotation::new();
    for step in 0..800_u16 {
        let mut gathered = FilterStep::new();
        for sample in 0..5_u16 {
            let t_s = f32::from(step * 5 + sample) * 0.01;
            gathered.add_rotation(&Matrix3::identity(), &Vector3::new(0.1, 0.0, rate(t_s)), 0.01);
        }
        rotation.update(&gathered);
    }
    rotation
}

#[test]
fn drilling_with_stick_slip_is_sustained_about_its_axis_and_a_gesture_is_not() {
    let drilling = after(|t_s| 6.0 + 3.0 * libm::sinf(1.6 * t_s));
    assert!(drilling.part() > 0.5 && drilling.square() > 18.0);
    assert_eq!(drilling.axes(), Some([false, false, true]));
    let gesture = after(|t_s| 6.0 * libm::sinf(3.0 * t_s));
    assert!(gesture.part() < 0.1 && gesture.axes().is_none());
}
