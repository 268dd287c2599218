use super::*;

#[test]
fn a_bias_that_p_makes_an_absurd_rate_of_is_refused_though_both_are_finite() {
    let scaled = |scale: f32, b: f32| GyroModel {
        p: [[scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale]],
        b_rad_s: [0.0, b, 0.0],
    };
    assert!(scaled(500.0, 1.9).is_valid() && scaled(0.01, 90_000.0).is_valid());
    assert!(!scaled(500.0, 2.1).is_valid(), "P b of 1,050 rad/s");
    assert!(!scaled(999.0, 1e36).is_valid(), "P b overflows");
    assert!(!scaled(1_001.0, 0.0).is_valid());
}
