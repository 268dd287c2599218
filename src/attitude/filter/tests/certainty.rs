//! Stated deviations: what the filter may not be certain of.

use super::*;

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
    gyro_scale::identified(&mut filter.state, &[0.001; 9], &filter.settings);
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

/// A filter whose past innovations have been a tenth of what was expected.
fn well_behaved() -> AttitudeFilter {
    let (mut filter, _) = turned_by_hand(&Matrix3::identity(), config::Motion::Hand);
    gyro_scale::identified(&mut filter.state, &[0.001; 9], &filter.settings);
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

#[test]
fn a_bias_that_no_rest_has_is_found_anew_at_rest() {
    let config = Config::default();
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    for k in 0..4_000 {
        if k == 2_000 {
            // Learnt, and held for certain, while a vector was wrong.
            filter.state.bias_rad_s = Vector3::new(0.1, -0.06, 0.02);
            (0..3).for_each(|axis| filter.state.errors.reset(BIAS + axis, 1e-8));
        }
        filter.propagate(0.005, &Vector3::zeros());
        filter.observe(Some(&Vector3::new(0.0, 0.0, -GRAVITY_M_S2)), Some(&Vector3::new(20.0, 0.0, 44.0)));
    }
    let left = filter.residual_bias_rad_s();
    assert!(left.norm() < 1e-3, "{left}");
}
