//! The estimator's attitude replaces that of a wrong gyro model; uncertainty while a string begins to turn.

use super::*;
use crate::{
    Config,
    attitude::{AttitudeFlags, error_state::HEADING},
    compensation::GyroModel,
    estimator::KnownAttitude,
    rotation::{exp_matrix, exp_quaternion, matrix},
};
use nalgebra::Quaternion;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const GRAVITY_M_S2: f32 = 9.806_65;

/// A filter that has stood level for 10 s, facing magnetic north, and whose gyro model has just been swapped.
fn doubted() -> AttitudeFilter {
    doubted_at(None)
}

/// The same, at this declination, rad.
fn doubted_at(declination_rad: Option<f32>) -> AttitudeFilter {
    let mut config = Config::default();
    config.earth.declination_rad = declination_rad;
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    for _ in 0..2_000 {
        filter.propagate(0.005, &Vector3::zeros());
        filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
    }
    assert!(!filter.is_doubted());
    let mut other = GyroModel::IDENTITY;
    other.p[1][2] = 0.08;
    filter.model_changed(&GyroModel::IDENTITY, &other, &[0.005; 12]);
    assert!(filter.is_doubted());
    filter
}

/// Angle between the filter's attitude and another, rad, where it is small.
fn off(filter: &AttitudeFilter, rotation: &Vector3<f32>) -> f32 {
    (matrix(&filter.state.propagation.q) - exp_matrix(rotation)).norm() / libm::sqrtf(2.0)
}

#[test]
fn a_wrong_models_attitude_is_replaced_by_one_that_is_known_better() {
    let truth = Vector3::new(0.1, -0.05, 0.5);
    let known = |sigma: f32| KnownAttitude {
        rotation: exp_matrix(&truth),
        covariance: Matrix3::from_diagonal_element(sigma * sigma),
    };
    let mut filter = doubted();
    filter.mark();
    filter.compare(&known(0.01));
    assert!(off(&filter, &truth) < 1e-5 && !filter.is_doubted(), "{}", off(&filter, &truth));
    let sigma = filter.attitude(crate::attitude::AttitudeFlags::empty()).unwrap().sigma_inclination_rad;
    assert!((0.005..0.03).contains(&sigma), "{sigma}");
    // One that gravity contradicts is not taken, however certain it says it is.
    let mut filter = doubted();
    filter.mark();
    filter.compare(&KnownAttitude { rotation: exp_matrix(&Vector3::new(0.4, 0.0, 0.5)), ..known(0.01) });
    assert!(off(&filter, &Vector3::zeros()) < 0.01 && !filter.is_doubted());
    // A less certain attitude is not taken, and without a mark none is.
    let mut filter = doubted();
    filter.mark();
    filter.compare(&known(0.3));
    assert!(off(&filter, &Vector3::zeros()) < 0.01 && !filter.is_doubted());
    let mut filter = doubted();
    filter.compare(&known(0.01));
    assert!(off(&filter, &Vector3::zeros()) < 0.01 && filter.is_doubted());
}

#[test]
fn a_heading_that_the_field_gives_better_stays_while_the_tilt_is_replaced() {
    let mut filter = doubted();
    for _ in 0..600 {
        filter.propagate(0.005, &Vector3::zeros());
        filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
    }
    filter.mark();
    let rotation = exp_matrix(&Vector3::new(0.0, 0.0, 0.6)) * exp_matrix(&Vector3::new(0.02, -0.01, 0.0));
    let covariance = Matrix3::from_diagonal(&Vector3::new(1e-10, 1e-10, 1.0));
    filter.compare(&KnownAttitude { rotation, covariance });
    assert!(off(&filter, &Vector3::new(0.02, -0.01, 0.0)) < 0.015, "{}", filter.state.propagation.q);
    let down = filter.state.rotation.transpose() * Vector3::z();
    assert!((down - rotation.transpose() * Vector3::z()).norm() < 1e-4, "{down}");
}

#[test]
fn a_change_within_what_the_gyro_was_thought_to_be_is_no_doubt() {
    let mut filter = doubted();
    filter.is_doubted = false;
    let mut near = GyroModel::IDENTITY;
    near.p[0][0] = 1.002;
    filter.model_changed(&GyroModel::IDENTITY, &near, &[0.005; 12]);
    assert!(!filter.is_doubted());
}

#[test]
fn a_string_that_begins_to_turn_takes_the_heading_along_by_no_more_than_is_told() {
    for (scale, top_rad_s) in [(1.02, 6.0), (0.98, 12.0), (1.01, -9.0)] {
        let config = Config::default();
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        let (mut psi, mut most) = (0.0_f32, 0.0_f32);
        for k in 0..6_000_u16 {
            // The string speeds up from 15 to 18 s.
            let spun_up = f32::from(k.saturating_sub(3_000).min(600)) / 600.0;
            let rate = Vector3::new(0.0, 0.0, top_rad_s * spun_up);
            psi += rate.z * 0.005;
            filter.propagate(0.005, &(rate * scale));
            let field = exp_matrix(&Vector3::new(0.0, 0.0, -psi)) * Vector3::new(20.0, 0.0, 44.0);
            filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&field));
            let Some(attitude) = filter.attitude(AttitudeFlags::empty()) else { continue };
            let error = libm::remainderf(attitude.magnetic_toolface_rad - psi, core::f32::consts::TAU).abs();
            let is_flagged = attitude.flags.intersects(AttitudeFlags::MAG_UNUSED | AttitudeFlags::NO_HEADING);
            assert!(is_flagged || error < 4.0 * attitude.sigma_toolface_rad, "{k}: {error} {attitude:?}");
            most = if error > most { error } else { most };
        }
        assert!(most < 0.35, "{scale} {top_rad_s}: {most}");
    }
}

/// Scale of a gyro whose factors and couplings err by no more than this, uniform.
fn scale_within(generator: &mut Xoshiro128PlusPlus, factor: f32, coupling: f32) -> Matrix3<f32> {
    let mut within = |bound: f32| (generator.next_u32() as f32 / u32::MAX as f32 - 0.5) * 2.0 * bound;
    Matrix3::from_fn(|r, c| if r == c { 1.0 + within(factor) } else { within(coupling) })
}

/// Flies 20 s by hand with this gyro after a rest. Returns the filter, and the true attitude.
fn turned_by_hand(scale: &Matrix3<f32>, motion: config::Motion) -> (AttitudeFilter, Quaternion<f32>) {
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, motion);
    let truth = turn_by_hand(&mut filter, crate::rotation::IDENTITY, scale);
    (filter, truth)
}

/// Goes on for 30 s from a true attitude, 20 s of them by hand. Returns the true attitude.
fn turn_by_hand(filter: &mut AttitudeFilter, mut truth: Quaternion<f32>, scale: &Matrix3<f32>) -> Quaternion<f32> {
    for k in 0..6_000_u16 {
        let t_s = f32::from(k.saturating_sub(2_000)) * 0.005;
        // Still for 10 s, then turned about all axes.
        let swing = |hertz: f32, most: f32| most * libm::sinf(core::f32::consts::TAU * hertz * t_s);
        let rate = Vector3::new(swing(0.31, 4.0), swing(0.23, 5.0), swing(0.41, 3.0));
        truth *= exp_quaternion(&(rate * 0.005));
        filter.propagate(0.005, &(scale * rate));
        let force = rotate_back(&truth, &Vector3::new(0.0, 0.0, -GRAVITY_M_S2));
        filter.observe(Some(&force), Some(&rotate_back(&truth, &Vector3::new(20.0, 0.0, 44.0))));
    }
    truth
}

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

#[test]
fn a_model_that_says_what_the_filter_has_found_changes_no_attitude_and_another_one_is_a_doubt() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(11);
    for _ in 0..10 {
        let scale = scale_within(&mut generator, 0.1, 0.05);
        let p = scale.try_inverse().unwrap();
        for (p, is_other) in [(p, false), (p + Matrix3::from_element(0.08), true)] {
            let (mut filter, _) = turned_by_hand(&scale, config::Motion::Hand);
            let before = filter.state.errors.variance(HEADING);
            let new = GyroModel { p: p.transpose().into(), ..GyroModel::IDENTITY };
            filter.model_changed(&GyroModel::IDENTITY, &new, &[0.005; 12]);
            let is_reset = filter.state.errors.variance(HEADING) > before;
            assert_eq!((filter.is_doubted(), is_reset), (is_other, is_other), "{scale}");
        }
    }
}

#[test]
fn a_gyro_that_lies_while_the_tool_slides_is_in_doubt_by_what_gravity_shows() {
    // Axis, and the rate that is not there.
    for (axis, rate_rad_s) in [(0, 0.02_f32), (0, -0.05), (1, 0.01), (1, -0.03)] {
        let config = Config::default();
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        let (mut worst_rad, mut silent_s) = (0.0_f32, 0.0_f32);
        for k in 0..8_000_u16 {
            // Honest for 20 s, wrong for 3, honest again.
            let mut rate = Vector3::zeros();
            rate[axis] = if (4_000..4_600).contains(&k) { rate_rad_s } else { 0.0 };
            filter.propagate(0.005, &rate);
            filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
            let Some(attitude) = filter.attitude(AttitudeFlags::empty()) else { continue };
            let error = attitude.inclination_rad;
            worst_rad = if error > worst_rad { error } else { worst_rad };
            silent_s += if error > 5.0 * attitude.sigma_inclination_rad { 0.005 } else { 0.0 };
        }
        assert!(worst_rad > 0.02 && silent_s < 1.0, "{axis} {rate_rad_s}: {worst_rad} rad, {silent_s} s");
    }
}

/// A lean near its gate comes and goes with the shaking: once a doubt has lasted for longer than its mean, it fades.
/// One that chance may have made ends with the lean.
#[test]
fn a_doubt_that_has_lasted_fades() {
    // Density of the shaking: the gates of the two means are 0.53 and 0.27 m/s^2.
    let (density, step_s) = (0.02, 0.05);
    for (lean_m_s2, leans_s, least_s, most_s) in [(0.6, 4.0, 3.0, 4.5), (0.8, 1.2, 0.5, 2.2)] {
        let mut filter = doubted();
        let AttitudeFilter { tilt, state, heading, settings, .. } = &mut filter;
        let mut in_doubt_s = 0.0;
        for k in 0..200_u16 {
            let leans = f32::from(k) * step_s < leans_s;
            let force = Vector3::new(if leans { lean_m_s2 } else { 0.0 }, 0.0, -GRAVITY_M_S2);
            tilt.check(state, heading, Some(force), density, step_s, settings);
            in_doubt_s += if !leans && tilt.doubt_rad.norm_squared() > 1e-4 { step_s } else { 0.0 };
        }
        assert!((least_s..most_s).contains(&in_doubt_s), "{leans_s} s: {in_doubt_s} s");
    }
}

#[test]
fn a_field_that_agrees_in_passing_is_not_used_before_it_has_agreed_for_half_a_second() {
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    let mut used_s = 0.0;
    for k in 0..6_000_u16 {
        // From 20 s on the gyro stands still, and the string turns once a second.
        let psi = if k < 4_000 { 0.0 } else { core::f32::consts::TAU * f32::from(k - 4_000) * 0.005 };
        filter.propagate(0.005, &Vector3::zeros());
        let field = exp_matrix(&Vector3::new(0.0, 0.0, -psi)) * Vector3::new(20.0, 0.0, 44.0);
        filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&field));
        let attitude = filter.attitude(AttitudeFlags::empty()).unwrap();
        used_s += if k > 4_040 && !attitude.flags.contains(AttitudeFlags::MAG_UNUSED) { 0.005 } else { 0.0 };
    }
    assert_eq!(used_s, 0.0);
}

/// Innovations that were small for minutes say nothing of an attitude that is lost, nor of a tilt that no force is read
/// against.
#[test]
fn what_innovations_showed_does_not_narrow_an_attitude_that_is_lost() {
    let (mut filter, truth) = turned_by_hand(&Matrix3::identity(), config::Motion::Hand);
    gyro_scale::identified(&mut filter.state, &[0.001; 9]);
    turn_by_hand(&mut filter, truth, &Matrix3::identity());
    let one = Matrix3::<f32>::identity();
    let before = filter.state.consistency.stated(&one, 0.0);
    assert!(before.m11 < 0.5 && before.m33 < 0.5, "{before}");
    let force = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
    for _ in 0..4_000 {
        filter.propagate(0.005, &Vector3::zeros());
        filter.observe(None, None);
    }
    let blind = filter.state.consistency.stated(&one, 0.0);
    assert!(blind.m11 > 0.95 * before.m11, "{blind} {before}");
    filter.gap(11.0);
    filter.observe(Some(&force), None);
    assert_eq!(filter.state.consistency.stated(&one, 0.0), one);
}

/// The estimator's north is magnetic, the filter's is true.
#[test]
fn an_attitude_that_is_taken_over_is_turned_by_the_declination() {
    for declination in [0.2, -0.4_f32] {
        let turn = exp_matrix(&Vector3::new(0.1, -0.05, 0.5));
        let covariance = Matrix3::from_diagonal_element(1e-4);
        let mut filter = doubted_at(Some(declination));
        filter.mark();
        filter.compare(&KnownAttitude { rotation: turn, covariance });
        let expected = exp_matrix(&Vector3::new(0.0, 0.0, declination)) * turn;
        assert!((filter.state.rotation - expected).norm() < 1e-5, "{declination}: {}", filter.state.rotation);
    }
}

/// A filter whose past innovations have been a tenth of what was expected.
fn well_behaved() -> AttitudeFilter {
    let (mut filter, _) = turned_by_hand(&Matrix3::identity(), config::Motion::Hand);
    gyro_scale::identified(&mut filter.state, &[0.001; 9]);
    for _ in 0..20_000 {
        filter.state.consistency.note_velocity(0.1, 0.05);
        filter.state.consistency.note_heading(0.1, 0.0, 0.05);
    }
    filter.sample.rate_rad_s = Vector3::zeros();
    filter
}

#[test]
fn past_innovations_do_not_narrow_what_a_gap_adds() {
    let mut filter = well_behaved();
    let before = filter.attitude_covariance();
    let blind = filter.blind_rad(0.9);
    filter.gap(0.9);
    let grown = (filter.attitude_covariance() - before).diagonal() / (blind * blind);
    assert!((grown - Vector3::repeat(1.0)).amax() < 0.02, "{grown}");
    // The same of an attitude that is taken over.
    let mut filter = well_behaved();
    filter.mark();
    let mut known = KnownAttitude { rotation: filter.state.rotation, covariance: Matrix3::from_diagonal_element(1e-8) };
    known.covariance.m33 = 1.0;
    filter.compare(&known);
    assert!(filter.state.consistency.stated(&Matrix3::identity(), 0.0).m11 > 0.999);
    filter.mark();
    known.covariance = Matrix3::from_diagonal_element(1e-9);
    filter.compare(&known);
    assert_eq!(filter.state.consistency.stated(&Matrix3::identity(), 0.0), Matrix3::identity());
}

#[test]
fn a_probe_that_was_turned_over_unseen_has_no_heading_until_a_field_gives_it() {
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    let mut stand = |seconds: u16, body_to_ned: &Matrix3<f32>, has_field: bool| {
        let [force, field] =
            [[0.0, 0.0, -GRAVITY_M_S2], [20.0, 0.0, 44.0]].map(|v| body_to_ned.transpose() * Vector3::from(v));
        for _ in 0..seconds * 200 {
            filter.propagate(0.005, &Vector3::zeros());
            filter.observe(Some(&force), has_field.then_some(&field));
        }
        let attitude = filter.attitude(AttitudeFlags::empty()).unwrap();
        let azimuth = libm::atan2f(body_to_ned[(1, 2)], body_to_ned[(0, 2)]);
        (attitude, libm::remainderf(attitude.azimuth_rad - azimuth, core::f32::consts::TAU).abs())
    };
    let tilted = exp_matrix(&Vector3::new(0.3, 0.9, -0.2));
    let (before, error) = stand(10, &tilted, true);
    assert!(before.sigma_azimuth_rad < 0.2 && error < 0.1, "{before:?}");
    // Turned by 100 deg about north, and by 60 deg about the vertical.
    let over = exp_matrix(&Vector3::new(0.0, 0.0, 1.0)) * exp_matrix(&Vector3::new(1.8, 0.0, 0.0)) * tilted;
    let (after, error) = stand(8, &over, false);
    assert!(error > 0.3 && after.sigma_azimuth_rad > 1.0, "{error} {after:?}");
    let (found, error) = stand(5, &over, true);
    assert!(found.sigma_azimuth_rad < 0.2 && error < 0.1, "{error} {found:?}");
}

/// An offset of the field that is known to 2 uT turns a heading read from 20 uT by a tenth of a radian.
#[test]
fn the_heading_is_no_more_certain_than_the_offset_that_is_taken_out_of_the_field() {
    let sigma = |variance_ut2: f32| {
        let config = Config::default();
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        filter.field_offset_known(variance_ut2);
        for _ in 0..12_000 {
            filter.propagate(0.005, &Vector3::zeros());
            filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
        }
        filter.attitude(AttitudeFlags::empty()).unwrap().sigma_toolface_rad
    };
    let [without, with] = [0.0, 4.0].map(sigma);
    assert!(without < 0.05 && (0.09..0.15).contains(&with), "{without} {with}");
}

/// An accelerometer's bias that is known to 0.1 m/s^2 leans the tilt by a hundredth of a radian where its axis is
/// level, and not where it points up.
#[test]
fn the_tilt_is_no_more_certain_than_the_force_that_is_taken_out() {
    let sigma = |variances: [f32; 3]| {
        let config = Config::default();
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        // The tool axis z leans by 30 deg to the north.
        let level = exp_matrix(&Vector3::new(0.0, -0.5, 0.0));
        for _ in 0..12_000 {
            filter.propagate(0.005, &Vector3::zeros());
            let body = |v: [f32; 3]| level * Vector3::from(v);
            filter.observe(Some(&body([0.0, 0.0, -GRAVITY_M_S2])), Some(&body([20.0, 0.0, 44.0])));
        }
        let taken_out = Vector3::from(variances);
        filter.attitude_by_corrected_force(AttitudeFlags::empty(), Some(&taken_out)).unwrap().sigma_inclination_rad
    };
    let [without, about, along] = [[0.0; 3], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0]].map(sigma);
    // The inclination turns about east, on which the bias of x acts with cos(0.5 rad).
    let expected = libm::hypotf(without, 0.1 * libm::cosf(0.5) / GRAVITY_M_S2);
    assert!((about / expected - 1.0).abs() < 0.02, "{about} {expected}");
    assert!((along / without - 1.0).abs() < 0.02, "{along} {without}");
}

/// The first tilt is a mean over half a second; a turn that the gyro has missed in it starts it over.
#[test]
fn a_turn_in_a_silence_while_the_first_tilt_is_averaged_starts_it_over() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(20);
    let mut uniform = |from: f32, to: f32| from + (to - from) * (generator.next_u32() as f32 / u32::MAX as f32);
    for run in 0..50 {
        let (rate, mut toolface) = (Vector3::new(0.0, 0.0, uniform(-6.0, 6.0)), uniform(-3.0, 3.0));
        let silent_from = uniform(0.05, 0.45);
        let silent_to = silent_from + uniform(0.06, 0.25);
        let lean = exp_matrix(&Vector3::new(0.0, uniform(0.3, 1.2), 0.0));
        let config = Config::default();
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config.identification.motion);
        let (mut unread_s, mut compared) = (0.0, 0);
        for k in 0..600_u16 {
            let t_s = f32::from(k) * 0.005;
            // It stands before the silence, and turns from its beginning on.
            let (is_silent, is_read) = ((silent_from..silent_to).contains(&t_s), t_s >= silent_to);
            toolface += if is_silent || is_read { rate.z * 0.005 } else { 0.0 };
            filter.propagate(0.005, &if is_read { rate } else { Vector3::zeros() });
            if is_silent {
                unread_s += 0.005;
                filter.unread(0.005, unread_s);
            }
            let to_body = (lean * exp_matrix(&Vector3::new(0.0, 0.0, toolface))).transpose();
            let force = to_body * Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
            let field = to_body * Vector3::new(20.0, 0.0, 44.0);
            filter.observe((!is_silent).then_some(&force), Some(&field));
            let Some(attitude) = filter.attitude(AttitudeFlags::empty()) else { continue };
            let off = libm::remainderf(attitude.gravity_toolface_rad - toolface, core::f32::consts::TAU).abs();
            if is_read && attitude.flags.is_empty() {
                compared += 1;
                assert!(off < 4.0 * attitude.sigma_toolface_rad, "run {run}, {t_s} s: {off} {attitude:?}");
            }
        }
        assert!(compared > 200, "run {run}: {compared}");
    }
}

/// In a steady rotation nothing tells a bias from a coupling: models whose parts change against each other read the same
/// rates, and what the filter has learnt of these stays. A model that is more certain of them replaces it.
#[test]
fn a_model_that_reads_the_same_steady_rate_changes_no_residual_bias() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(12);
    let config = Config::default();
    let turn = |t: f32| matrix(&exp_quaternion(&Vector3::new(0.0, 0.8, 0.0))) * exp_matrix(&Vector3::new(0.0, 0.0, t));
    for _ in 0..10 {
        let mut draw = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
        let speed = 2.0 + 2.0 * draw();
        let error = Vector3::new(draw(), draw(), draw()) * 0.02;
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config::Motion::DrillString);
        for k in 0..8_000_u16 {
            filter.propagate(0.005, &(Vector3::new(0.0, 0.0, speed) + error));
            let body = turn(speed * 0.005 * f32::from(k)).transpose();
            let (force, field) = (Vector3::new(0.0, 0.0, -GRAVITY_M_S2), Vector3::new(20.0, 0.0, 44.0));
            filter.observe(Some(&(body * force)), Some(&(body * field)));
        }
        let (learnt, sigma) = (filter.state.bias_rad_s, filter.residual_bias_sigma_rad_s());
        for k in 0..3 {
            assert!((learnt[k] - error[k]).abs() < 3.0 * sigma[k], "{speed}: {learnt} {error} {sigma}");
        }
        let mut new = GyroModel::IDENTITY;
        for k in 0..3 {
            let coupling = 0.01 * draw();
            new.p[k][2] += coupling;
            new.b_rad_s[k] = coupling * speed;
        }
        filter.model_changed(&GyroModel::IDENTITY, &new, &[0.5; 12]);
        assert!((filter.state.bias_rad_s - learnt).norm() < 1e-3, "{speed}: {} {learnt}", filter.state.bias_rad_s);
        // The same change back, of a model that is certain.
        filter.model_changed(&new, &GyroModel::IDENTITY, &[1e-4; 12]);
        let now = filter.residual_bias_sigma_rad_s();
        for k in 0..3 {
            let stated = config.attitude.gyro_bias_sigma_rad_s;
            let (kept, dropped) = (sigma[k] < 0.99 * stated, sigma[k] > 1.01 * stated);
            assert!(
                !dropped || (filter.state.bias_rad_s[k] == 0.0 && now[k] < 1.01 * stated),
                "{speed}: {sigma} {now}"
            );
            assert!(!kept || (filter.state.bias_rad_s[k] - learnt[k]).abs() < 1e-3, "{speed}: {sigma} {now}");
        }
    }
}
