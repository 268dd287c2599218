//! The stated covariance follows what the innovations show.

use super::*;

#[test]
fn what_is_stated_follows_what_is_seen_down_within_half_a_minute_and_up_within_seconds() {
    let mut consistency = Consistency::new();
    let one = Matrix3::<f32>::identity();
    let steps = |consistency: &mut Consistency, seconds: u16, ratio: f32| {
        for _ in 0..seconds * 20 {
            consistency.note_heading(ratio, 0.05);
            consistency.note_velocity(0.04, 0.05);
            consistency.note_velocity(0.04, 0.05);
        }
    };
    assert_eq!(consistency.stated(&one), one);
    steps(&mut consistency, 120, 0.25);
    let stated = consistency.stated(&one);
    assert!((stated.m33 - 0.25).abs() < 0.02 && stated.m11 >= LEAST && stated.m11 < 0.12, "{stated}");
    steps(&mut consistency, 9, 4.0);
    assert!((0.9..=1.0).contains(&consistency.stated(&one).m33));
    // Tilt and heading stay as correlated as before.
    let mut common = one;
    (common.m13, common.m31) = (0.5, 0.5);
    let stated = consistency.stated(&common);
    assert!((stated.m13 / libm::sqrtf(stated.m11 * stated.m33) - 0.5).abs() < 1e-5);
}
