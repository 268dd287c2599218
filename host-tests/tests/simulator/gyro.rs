use super::ideal::{attitude, files, vector, without_sensor_errors};
use meerkat_mwd::compensation::GyroModel;
use nalgebra::Vector3;
use testbed::{
    flight::Flight,
    score::{Settings, score, systematic_rate_error_rad_s},
    simulate::{EarthSettings, Scenario, Truth, simulate},
    trace::Trace,
};

#[test]
fn the_true_gyro_model_recovers_the_true_rate_up_to_noise() {
    let mut scenario = Scenario { duration_s: 60.0, ..Scenario::default() };
    scenario.gyro.bias_walk_deg_s_rts = 0.0;
    let residual = |scenario: &Scenario| {
        let (trace, truth) = simulate(scenario, 11);
        let p = truth.gyro.p_matrix().map(f64::from);
        let rates = trace.true_rate.unwrap();
        let square: f64 = trace
            .samples
            .iter()
            .zip(&rates)
            .map(|(s, &w)| (p * (vector(s.gyro_rad_s) - vector(truth.gyro.b_rad_s)) - Vector3::from(w)).norm_squared())
            .sum();
        (square / (3.0 * rates.len() as f64)).sqrt().to_degrees()
    };
    // 0.01 deg/s/rtHz at 100 Hz is 0.1 deg/s a reading; P, within some percent of 1, goes on top.
    let noisy = residual(&scenario);
    assert!((noisy - 0.1).abs() < 0.012, "{noisy}");
    scenario.gyro.noise_deg_s_rthz = 0.0;
    assert!(residual(&scenario) < 1e-4);
}

#[test]
fn the_true_gyro_model_scores_its_noise_alone_over_two_seconds() {
    for mut scenario in files() {
        scenario.gyro.bias_walk_deg_s_rts = 0.0;
        let (trace, truth) = simulate(&Scenario { duration_s: 200.0, ..scenario }, 12);
        let settings = Settings { from_us: 15_000_000, factory: truth.gyro, ..Settings::default() };
        let scores = score(&trace, &Flight::default(), &settings).unwrap().orientation_2s_rms_deg;
        // Angle random walk over 2 s on three axes.
        let noise = 0.01 * 6_f64.sqrt();
        assert!((0.8 * noise..1.2 * noise).contains(&scores.bias_only.unwrap()), "{scores:?}");
        assert!(scores.uncompensated.unwrap() > 3.0, "{scores:?}");
        assert_eq!(scores.with_effects, None);
    }
}

#[test]
fn integrated_noise_and_bias_walk_as_their_densities_say() {
    // At rest for 100 s, 200 seeds: angle random walk 0.01 deg/rt(s) * 10, bias walk 0.05 deg/s/rt(s) * 10.
    let mut scenario = without_sensor_errors(Scenario { duration_s: 100.0, rest_s: 200.0, ..Scenario::default() });
    scenario.sample_period_us = 20_000;
    let rms = |scenario: &Scenario, f: &dyn Fn(&Trace) -> Vector3<f64>| {
        let square: f64 = (0..200).map(|seed| f(&simulate(scenario, seed).0).norm_squared()).sum();
        (square / 600.0).sqrt().to_degrees()
    };
    scenario.gyro.noise_deg_s_rthz = 0.01;
    let angle = |trace: &Trace| trace.samples.iter().map(|s| vector(s.gyro_rad_s)).sum::<Vector3<f64>>() * 0.02;
    let walked = rms(&scenario, &angle);
    assert!((walked - 0.1).abs() < 0.015, "{walked}");
    scenario.gyro.noise_deg_s_rthz = 0.0;
    scenario.gyro.bias_walk_deg_s_rts = 0.05;
    let drifted = rms(&scenario, &|trace| vector(trace.samples.last().unwrap().gyro_rad_s));
    assert!((drifted - 0.5).abs() < 0.075, "{drifted}");
}

#[test]
fn gyro_errors_are_drawn_off_centre_and_the_raw_gyro_errs_by_degrees_a_second() {
    let [_, inclined] = files();
    let mut errors = Vec::new();
    for seed in 0..20 {
        let (trace, Truth { gyro, .. }) = simulate(&Scenario { duration_s: 40.0, ..inclined.clone() }, seed);
        for (row, values) in gyro.p.iter().enumerate() {
            for (column, &value) in values.iter().enumerate() {
                let (off, sigma) = if row == column { (value - 1.0, 0.04) } else { (value, 0.02) };
                assert!(off.abs() > 0.499 * sigma && off.abs() < 5.0 * sigma, "seed {seed}: {value}");
            }
        }
        assert!(gyro.b_rad_s.iter().all(|b| b.abs().to_degrees() > 0.499));
        let rates = &trace.true_rate.unwrap()[1_500..];
        errors.push(systematic_rate_error_rad_s(&gyro, &GyroModel::IDENTITY, rates).unwrap().to_degrees());
        assert!(systematic_rate_error_rad_s(&gyro, &gyro, rates).unwrap() < 1e-6);
    }
    errors.sort_by(f64::total_cmp);
    assert!((3.0..9.0).contains(&errors[10]), "median {}", errors[10]);
}

#[test]
fn with_a_latitude_the_gyro_at_rest_reads_the_earth_and_the_true_rate_does_not() {
    let earth =
        EarthSettings { latitude_deg: Some(60.0), magnetic_declination_deg: Some(10.0), ..EarthSettings::default() };
    let (trace, _) = simulate(&without_sensor_errors(Scenario { duration_s: 5.0, earth, ..Scenario::default() }), 1);
    let rate = (attitude(&trace, 100) * vector(trace.samples[100].gyro_rad_s)).map(|x| x.to_degrees() * 3600.0);
    // 15.041 deg/h: half of it to true north, which is 10 deg west of magnetic north, the rest up.
    let north = 15.041 * 0.5;
    let (sine, cosine) = 10_f64.to_radians().sin_cos();
    let expected = Vector3::new(north * cosine, -north * sine, -15.041 * 0.75_f64.sqrt());
    assert!((rate - expected).norm() < 1e-3, "{rate}");
    assert_eq!(trace.true_rate.unwrap()[100], [0.0; 3]);
}
