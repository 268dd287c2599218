//! A new gyro model: which attitude and bias it leaves, and the doubt of a wrong one.

use super::*;

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
        assert!(worst_rad > 0.015 && silent_s < 1.0, "{axis} {rate_rad_s}: {worst_rad} rad, {silent_s} s");
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

/// In a steady rotation nothing tells a bias from a coupling: models whose parts change against each other read the
/// same rates, and what the filter has learnt of these stays. A model that is more certain of them replaces it.
#[test]
fn a_model_that_reads_the_same_steady_rate_changes_nothing_that_was_learnt_of_it() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(12);
    let config = Config::default();
    let turn = |t: f32| matrix(&exp_quaternion(&Vector3::new(0.0, 0.8, 0.0))) * exp_matrix(&Vector3::new(0.0, 0.0, t));
    for _ in 0..10 {
        let mut draw = || generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
        let speed = 2.0 + 2.0 * draw();
        let error = Vector3::new(draw(), draw(), draw()) * 0.02;
        let read = Vector3::new(0.0, 0.0, speed) + error;
        let mut filter = AttitudeFilter::new();
        filter.start(&config.attitude, &config.earth, config::Motion::DrillString);
        for k in 0..8_000_u16 {
            filter.propagate(0.005, &read);
            let body = turn(speed * 0.005 * f32::from(k)).transpose();
            let (force, field) = (Vector3::new(0.0, 0.0, -GRAVITY_M_S2), Vector3::new(20.0, 0.0, 44.0));
            filter.observe(Some(&(body * force)), Some(&(body * field)));
        }
        let (learnt, sigma) = (read - filter.state.corrected(&read), filter.residual_bias_sigma_rad_s());
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
        // The new model reads the same; the bias alone stands for what was learnt.
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
