//! The gyro's scale, found while the tool turns.

use super::*;

/// Error of the attitude after 20 s by hand with this gyro, rad.
fn carried(scale: &Matrix3<f32>) -> f32 {
    let (filter, truth) = turned_by_hand(scale, config::Motion::Hand);
    (matrix(&filter.state.propagation.q) - matrix(&truth)).norm() / libm::sqrtf(2.0)
}

#[test]
fn a_gyro_that_is_off_is_found_by_hand_within_seconds() {
    let off = Matrix3::new(1.06, 0.02, -0.03, 0.0, 0.93, 0.02, 0.03, -0.01, 1.04);
    let [perfect, found] = [Matrix3::identity(), off].map(|scale| carried(&scale));
    assert!(perfect < 0.01 && found < 0.05, "{perfect} {found}");
}

/// Worst error of the toolface while a string turns again after a pause, in its deviations and in radians: an inclined
/// tool that rested, turned for 4 s and rested for 7 s, with this gyro.
fn turned_again(generator: &mut Xoshiro128PlusPlus) -> (f32, f32) {
    let mut within = |bound: f32| (generator.next_u32() as f32 / u32::MAX as f32 - 0.5) * 2.0 * bound;
    let (inclination, azimuth, toolface) = (0.9 + within(0.6), within(PI), within(PI));
    let (speed, back) = (5.5 + within(3.5), within(1.0).signum());
    // Factors at a data sheet's limit and a fifth beyond it.
    let scale = Matrix3::from_fn(|r, c| if r == c { 1.0 + 0.036 * within(1.0).signum() } else { within(0.02) });
    let mut truth = exp_quaternion(&Vector3::new(0.0, 0.0, azimuth))
        * exp_quaternion(&Vector3::new(0.0, inclination, 0.0))
        * exp_quaternion(&Vector3::new(0.0, 0.0, toolface));
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config::Motion::DrillString);
    let (mut worst, mut worst_rad) = (0.0, 0.0);
    for k in 0..3_600_u16 {
        let turns = if (400..1_200).contains(&k) { 1.0 } else { back * f32::from(k >= 2_600) };
        // With stick-slip.
        let rate = Vector3::new(0.0, 0.0, turns * speed * (1.0 + 0.5 * libm::sinf(0.015 * f32::from(k))));
        truth *= exp_quaternion(&(rate * 0.005));
        filter.propagate(0.005, &(scale * rate));
        let shaken = Vector3::from_fn(|_, _| turns * within(1.7));
        let force = rotate_back(&truth, &Vector3::new(0.0, 0.0, -GRAVITY_M_S2)) + shaken;
        filter.observe(Some(&force), Some(&rotate_back(&truth, &Vector3::new(20.0, 0.0, 44.0))));
        let Some(attitude) = filter.attitude(AttitudeFlags::empty()) else { continue };
        let to_ned = matrix(&truth);
        let off = attitude.gravity_toolface_rad - libm::atan2f(to_ned.m32, -to_ned.m31);
        let error = libm::remainderf(off, core::f32::consts::TAU).abs();
        if k >= 2_600 && error > worst_rad {
            (worst, worst_rad) = (error / attitude.sigma_toolface_rad, error);
        }
    }
    (worst, worst_rad)
}

#[test]
fn a_string_that_turns_again_errs_by_no_more_than_its_first_turn_left_open() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(11);
    let (mut most, mut mean_square) = (0.0_f32, 0.0);
    for _ in 0..60 {
        let (worst, worst_rad) = turned_again(&mut generator);
        most = if worst > most { worst } else { most };
        mean_square += worst_rad * worst_rad / 60.0;
    }
    // With the scale's error as noise 2.6 deviations and 0.23 rad.
    let worst_rad = libm::sqrtf(mean_square);
    assert!(most < 2.0 && worst_rad < 0.15, "{most} deviations, {worst_rad} rad");
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
