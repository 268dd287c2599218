use super::*;

#[test]
fn a_level_begins_at_its_bound() {
    let levels = [0.0, 0.49, 0.5, 0.99, 1.0, 2.5, 4.9, 7.9, 14.9, 15.1, f32::INFINITY];
    let levels = levels.map(|g| of_vibration(g * STANDARD_GRAVITY_M_S2));
    assert_eq!(levels, [0, 0, 1, 1, 2, 3, 4, 5, 6, 7, 7]);
    let rotation = |min_rpm, max_rpm, index| Rotation { min_rpm, mean_rpm: 100.0, max_rpm, stick_slip_index: index };
    assert_eq!(rotation(90.0, 110.0, Some(0.1)).stick_slip_severity(), Some(0));
    assert_eq!(rotation(30.0, 170.0, Some(0.7)).stick_slip_severity(), Some(3));
    assert_eq!(rotation(0.0, 260.0, Some(1.3)).stick_slip_severity(), Some(6));
    assert_eq!(rotation(-5.0, 260.0, Some(1.3)).stick_slip_severity(), Some(7));
    // A least speed of -0.1 rpm is within the gyro's bias at rest: the string did not turn backwards.
    assert_eq!(rotation(-0.1, 260.0, Some(1.3)).stick_slip_severity(), Some(6));
    assert_eq!(rotation(0.0, 1.0, None).stick_slip_severity(), None);
}
