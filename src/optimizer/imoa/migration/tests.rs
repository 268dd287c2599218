use super::quarter_sine;

#[test]
fn the_series_is_within_its_bound() {
    for k in 0..=1_000 {
        let x = k as f32 / 1_000.0;
        assert!((quarter_sine(x) - libm::sinf(core::f32::consts::FRAC_PI_2 * x)).abs() < 2e-4, "{x}");
    }
}
