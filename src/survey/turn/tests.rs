use super::*;

#[test]
fn steps_of_every_size_add_up_to_their_sum() {
    for step in [1e-4_f32, 0.03, -0.1, 0.49, 0.51, -2.0] {
        let mut turn = Turn::NONE;
        (0..2_000).for_each(|_| turn.by(step));
        let (s, c) = libm::sincos(2_000.0 * f64::from(step));
        let v = turn.back(&Vector3::x());
        assert!((f64::from(v.x) - c).abs() < 2e-4 && (f64::from(v.y) - s).abs() < 2e-4, "{step} {v} {c} {s}");
    }
}
