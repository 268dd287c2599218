//! The gyro's scale, found while the tool turns.

use super::*;

/// Error of the attitude after 20 s by hand with this gyro, rad.
fn carried(scale: &Matrix3<f32>, motion: config::Motion) -> f32 {
    let (filter, truth) = turned_by_hand(scale, motion);
    (matrix(&filter.state.propagation.q) - matrix(&truth)).norm() / libm::sqrtf(2.0)
}

#[test]
fn a_gyro_that_is_off_is_found_by_hand_within_seconds() {
    let off = Matrix3::new(1.06, 0.02, -0.03, 0.0, 0.93, 0.02, 0.03, -0.01, 1.04);
    let [perfect, found] = [Matrix3::identity(), off].map(|scale| carried(&scale, config::Motion::Hand));
    let as_noise = carried(&off, config::Motion::DrillString);
    assert!(perfect < 0.01 && found < 0.05 && found < 0.25 * as_noise, "{perfect} {found} {as_noise}");
}

#[test]
fn a_scale_is_found_again_after_a_covariance_that_is_not_sound() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
    for _ in 0..10 {
        let scale = scale_within(&mut generator, 0.1, 0.05);
        let (mut filter, truth) = turned_by_hand(&scale, config::Motion::Hand);
        filter.state.errors.reset(BIAS, f32::NAN);
        turn_by_hand(&mut filter, truth, &scale);
        let left = ((Matrix3::identity() + filter.state.scale.errors) * scale - Matrix3::identity()).norm();
        assert!(left < 0.25 * (scale - Matrix3::identity()).norm(), "{scale}: {left}");
    }
}

#[test]
fn a_gyro_is_taken_for_uncalibrated_where_it_is_and_not_within_its_data_sheet() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
    // Largest error of a factor and of a coupling; the second are a uniform data sheet's of 1 and 0.5 %.
    for (factor, coupling, is_uncalibrated) in [(0.1, 0.05, true), (0.01, 0.005, false)] {
        for _ in 0..20 {
            let scale = scale_within(&mut generator, factor, coupling);
            let (filter, _) = turned_by_hand(&scale, config::Motion::Hand);
            assert_eq!(filter.state.scale.by_data_sheet, !is_uncalibrated, "{scale}");
        }
    }
}

#[test]
fn a_gyro_within_its_data_sheet_is_not_taken_for_uncalibrated_by_a_long_rest() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
    for _ in 0..10 {
        let scale = scale_within(&mut generator, 0.015, 0.01);
        let (mut filter, truth) = turned_by_hand(&scale, config::Motion::Hand);
        let found = filter.state.scale.errors;
        let force = rotate_back(&truth, &Vector3::new(0.0, 0.0, -GRAVITY_M_S2));
        let field = rotate_back(&truth, &Vector3::new(20.0, 0.0, 44.0));
        // Two hours, ten samples a second.
        for _ in 0..72_000 {
            filter.propagate(0.1, &Vector3::zeros());
            filter.observe(Some(&force), Some(&field));
        }
        assert!(filter.state.scale.by_data_sheet, "{scale}");
        let change = (filter.state.scale.errors - found).norm();
        // Half of what the data sheet allows: gravity and field still average.
        assert!(change < 0.005, "{scale}: {change}");
    }
}
