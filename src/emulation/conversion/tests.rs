use super::*;

#[test]
fn a_word_is_within_half_a_unit_of_the_value_or_at_its_limit() {
    let limits = (-32_768, 32_767);
    for step in -4_000..4_000 {
        let value = step as f32 * 0.017;
        let error = quantised(value, 0.25, limits) as f32 * 0.25 - value;
        assert!(libm::fabsf(error) <= 0.125 + 1e-5, "{value}: {error}");
    }
    assert_eq!(quantised(1e9, 0.25, limits), 32_767);
    assert_eq!(quantised(f32::NEG_INFINITY, 0.25, limits), -32_768);
    assert_eq!(quantised(f32::NAN, 0.25, limits), 0);
}

#[test]
fn the_truth_between_samples_is_on_the_line_between_them() {
    let mut played = Played::nothing();
    let sample = |t_us, x| Sample { t_us, mag_ut: [x, 0.0, -x], ..Sample::default() };
    played.take(&sample(1_000, 4.0));
    played.take(&sample(2_000, 8.0));
    assert_eq!(played.at(1_250_000).map(|s| s.mag_ut), Some([5.0, 0.0, -5.0]));
    assert_eq!(played.at(9_000_000).map(|s| s.mag_ut), Some([8.0, 0.0, -8.0]));
}
