//! The simulator against physics: what its columns say about each other, in closed forms and by an independent integration.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use meerkat_mwd::{SampleFlags, compensation::GyroModel};
use mwd::{
    cli::SimulateArgs,
    flight::Flight,
    score::{Settings, score, systematic_rate_error_rad_s},
    simulate::{
        EarthSettings, Effects, HardIronInterval, Hole, MountRotation, Rotation, Scenario, ScenarioError,
        ShockSettings, Truth, Vibration, Wobble, simulate,
    },
    trace::Trace,
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn scenario_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)
}

fn files() -> [Scenario; 2] {
    ["drilling_vertical.toml", "drilling_45deg.toml"].map(|name| Scenario::read(&scenario_file(name)).unwrap())
}

/// A perfect gyro, accelerometer and magnetometer.
fn without_sensor_errors(mut scenario: Scenario) -> Scenario {
    scenario.gyro.p = Some(IDENTITY);
    scenario.gyro.bias_deg_s = Some([0.0; 3]);
    scenario.gyro.noise_deg_s_rthz = 0.0;
    scenario.gyro.bias_walk_deg_s_rts = 0.0;
    scenario.accel.noise_ug_rthz = 0.0;
    scenario.mag.noise_ut = 0.0;
    scenario
}

/// Rotation alone: no vibration, no shocks, no wobble.
fn smooth(scenario: Scenario) -> Scenario {
    Scenario {
        vibration: Vibration {
            lateral_m_s2: 0.0,
            axial_m_s2: 0.0,
            chatter_m_s2: 0.0,
            angular_deg_s: 0.0,
            ..scenario.vibration
        },
        shocks: ShockSettings { per_minute: 0.0, ..scenario.shocks },
        wobble: Wobble { rms_deg: 0.0, ..scenario.wobble },
        ..scenario
    }
}

fn attitude(trace: &Trace, i: usize) -> UnitQuaternion<f64> {
    let [w, x, y, z] = trace.reference[i].unwrap();
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

fn vector(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}

#[test]
fn the_true_rate_integrates_to_the_true_attitude() {
    for scenario in files() {
        let (trace, _) = simulate(&Scenario { duration_s: 75.0, ..scenario }, 3);
        let rates = trace.true_rate.as_ref().unwrap();
        let first = 1_000;
        let mut q = attitude(&trace, first);
        for i in first..first + 6_000 {
            let [a, b] = [Vector3::from(rates[i]), Vector3::from(rates[i + 1])];
            q *= UnitQuaternion::from_scaled_axis((a + b) * 0.005 + a.cross(&b) * (1e-4 / 12.0));
        }
        let error = q.angle_to(&attitude(&trace, first + 6_000)).to_degrees();
        assert!(error < 0.05, "{error} deg after 60 s");
    }
}

#[test]
fn at_rest_the_readings_give_back_inclination_azimuth_and_toolface() {
    for (inclination_deg, azimuth_deg, toolface_deg) in [(45.0, 60.0, 35.0), (5.0, 300.0, 200.0), (90.0, 180.0, 90.0)] {
        let scenario = without_sensor_errors(Scenario {
            duration_s: 5.0,
            hole: Hole { inclination_deg, azimuth_deg, ..Hole::default() },
            rotation: Rotation { toolface_deg, ..Rotation::default() },
            ..Scenario::default()
        });
        let (trace, _) = simulate(&scenario, 1);
        for sample in &trace.samples {
            let (g, b) = (-vector(sample.accel_m_s2), vector(sample.mag_ut));
            assert_eq!(sample.gyro_rad_s, [0.0; 3]);
            assert!((g.norm() - 9.806_65).abs() < 1e-5);
            // The six-axis formulas of a survey.
            let inclination = g.x.hypot(g.y).atan2(g.z);
            let toolface = g.y.atan2(-g.x);
            let horizontal = g.x * g.x + g.y * g.y;
            let azimuth = ((g.x * b.y - g.y * b.x) * g.norm()).atan2(b.z * horizontal - g.z * (g.x * b.x + g.y * b.y));
            assert!((inclination.to_degrees() - inclination_deg).abs() < 1e-4);
            assert!((toolface.to_degrees().rem_euclid(360.0) - toolface_deg).abs() < 1e-3);
            assert!((azimuth.to_degrees().rem_euclid(360.0) - azimuth_deg).abs() < 1e-3);
            assert!(((g.dot(&b) / (g.norm() * b.norm())).asin().to_degrees() - 65.0).abs() < 1e-4);
        }
    }
}

#[test]
fn the_field_keeps_its_norm_and_points_where_the_attitude_says() {
    for scenario in files() {
        let (trace, _) = simulate(&without_sensor_errors(Scenario { duration_s: 60.0, ..scenario }), 2);
        let dip = 65_f64.to_radians();
        let field_ned = Vector3::new(dip.cos(), 0.0, dip.sin()) * 50.0;
        for (i, sample) in trace.samples.iter().enumerate() {
            // A mean over 10 ms at 360 deg/s: (1.8 deg)^2 / 6 of the turning part.
            assert!((vector(sample.mag_ut).norm() - 50.0).abs() < 0.01);
            assert!((attitude(&trace, i) * vector(sample.mag_ut) - field_ned).norm() < 0.1);
        }
    }
}

#[test]
fn vibration_has_no_mean_in_the_earth_and_gravity_stays() {
    for scenario in files() {
        let (trace, _) = simulate(&scenario, 5);
        let drilling = 2_000..trace.samples.len();
        let n = drilling.len() as f64;
        let mean =
            drilling.map(|i| attitude(&trace, i) * vector(trace.samples[i].accel_m_s2)).sum::<Vector3<f64>>() / n;
        assert!((mean - Vector3::new(0.0, 0.0, -9.806_65)).norm() < 0.02, "{mean}");
    }
}

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
fn the_same_seed_gives_the_same_bytes_and_another_seed_another_run() {
    let scenario = Scenario { duration_s: 20.0, ..Scenario::default() };
    let directory = tempfile::tempdir().unwrap();
    let bytes = |seed, name: &str| {
        let path = directory.path().join(name);
        simulate(&scenario, seed).0.write(&path).unwrap();
        std::fs::read(path).unwrap()
    };
    let first = bytes(1, "a.csv.gz");
    assert_eq!(first, bytes(1, "a.csv.gz"));
    assert_ne!(first, bytes(2, "a.csv.gz"));
    assert_ne!(simulate(&scenario, 1).1, simulate(&scenario, 2).1);
}

#[test]
fn a_changed_setting_leaves_the_draws_of_the_others() {
    let scenario = Scenario { duration_s: 30.0, ..Scenario::default() };
    let mut noisier = scenario.clone();
    noisier.shocks.per_minute = 200.0;
    noisier.gyro.noise_deg_s_rthz = 0.1;
    let ((a, truth_a), (b, truth_b)) = (simulate(&scenario, 6), simulate(&noisier, 6));
    assert_eq!(truth_a.gyro, truth_b.gyro);
    assert_eq!(a.reference, b.reference);
    assert_ne!(a.samples, b.samples);
}

#[test]
fn an_effect_on_one_sensor_leaves_the_others_to_the_bit() {
    let scenario = Scenario { duration_s: 30.0, ..Scenario::default() };
    let with = |effects: Effects| simulate(&Scenario { effects, ..scenario.clone() }, 6).0;
    let clean = with(Effects::default());
    let gyro = with(Effects {
        vibration_rectification_deg_s_g2: [0.01, 0.0, 0.02],
        gyro_scale_nonlinearity_s2_rad2: [1e-3; 3],
        gyro_scale_asymmetry: [1e-3; 3],
        periodic_bias_deg_s: [0.1; 3],
        periodic_bias_period_s: 7.0,
        mount_rotation: Some(MountRotation { from_s: 15.0, rotation_deg: [1.0, 2.0, 3.0], ramp_s: 1.0 }),
        ..Effects::default()
    });
    let accel = with(Effects { accel_lag_ms: 3.0, lever_arm_mm: [20.0, 0.0, 0.0], ..Effects::default() });
    let magnet = HardIronInterval { from_s: 0.5, to_s: 29.0, offset_ut: [5.0, 0.0, 3.0], ramp_s: 0.3 };
    let mag = with(Effects { eddy_lag_ms: 2.0, hard_iron_intervals: vec![magnet], ..Effects::default() });
    for trace in [&gyro, &accel, &mag] {
        assert_eq!((&trace.reference, &trace.true_rate), (&clean.reference, &clean.true_rate));
    }
    for i in 2_000..clean.samples.len() {
        let [clean, gyro, accel, mag] = [&clean, &gyro, &accel, &mag].map(|trace| trace.samples[i]);
        assert!(gyro.gyro_rad_s != clean.gyro_rad_s && mag.mag_ut != clean.mag_ut);
        assert_eq!((gyro.accel_m_s2, gyro.mag_ut), (clean.accel_m_s2, clean.mag_ut));
        assert_eq!((accel.gyro_rad_s, accel.mag_ut), (clean.gyro_rad_s, clean.mag_ut));
        assert_eq!((mag.gyro_rad_s, mag.accel_m_s2), (clean.gyro_rad_s, clean.accel_m_s2));
    }
    assert!(accel.samples[2_000..].iter().zip(&clean.samples[2_000..]).any(|(a, b)| a.accel_m_s2 != b.accel_m_s2));
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
fn the_tool_stands_still_then_turns_between_nothing_and_twice_the_mean() {
    for scenario in files() {
        let (trace, _) = simulate(&smooth(scenario), 9);
        let rates = trace.true_rate.unwrap();
        let deg_s = |i: usize| rates[i][2].to_degrees();
        assert!((0..999).all(|i| rates[i] == [0.0; 3]));
        let drilling = 1_300..rates.len();
        assert!(drilling.clone().all(|i| deg_s(i) > -1e-9 && deg_s(i) < 2.0 * 180.0 * 0.96));
        assert!(drilling.clone().any(|i| deg_s(i) < 30.0) && drilling.clone().any(|i| deg_s(i) > 330.0));
        let mean = drilling.clone().map(deg_s).sum::<f64>() / drilling.len() as f64;
        assert!((mean - 180.0).abs() < 2.0, "{mean}");
    }
}

#[test]
fn shocks_land_in_the_accelerometer_at_their_time() {
    let mut scenario = smooth(without_sensor_errors(Scenario { duration_s: 70.0, ..Scenario::default() }));
    let quiet = simulate(&scenario, 8).0;
    scenario.shocks.per_minute = 20.0;
    scenario.shocks.rebound_ms = 0.0;
    let (shaken, truth) = simulate(&scenario, 8);
    // 20 expected in the minute after the rest.
    assert!((truth.shocks.len() as f64 - 20.0).abs() < 4.0 * 20_f64.sqrt());
    let mut impulse = 0.0;
    for (a, b) in quiet.samples.iter().zip(&shaken.samples) {
        let difference = vector(b.accel_m_s2) - vector(a.accel_m_s2);
        impulse += difference.norm() * 0.01;
        let (from, to) = (a.t_us as f64 * 1e-6 - 0.005, a.t_us as f64 * 1e-6 + 0.005);
        let hit = truth.shocks.iter().any(|s| s.start_s < to && s.start_s + s.length_s > from);
        assert_eq!(difference.norm() > 0.0, hit, "at {from}");
    }
    let half_sine = 2.0 / std::f64::consts::PI;
    let expected: f64 = truth.shocks.iter().map(|s| Vector3::from(s.peak_m_s2).norm() * s.length_s * half_sine).sum();
    assert!((impulse / expected - 1.0).abs() < 0.01, "{impulse} {expected}");
}

#[test]
fn a_lever_arm_adds_the_centripetal_and_tangential_acceleration() {
    let steady = Rotation { stick_slip: 0.0, ..Rotation::default() };
    let mut scenario =
        smooth(without_sensor_errors(Scenario { duration_s: 30.0, rotation: steady, ..Scenario::default() }));
    let centred = simulate(&scenario, 1).0;
    scenario.accel.lever_arm_m = [0.02, 0.0, 0.3];
    let off_centre = simulate(&scenario, 1).0;
    let added = |i: usize| vector(off_centre.samples[i].accel_m_s2) - vector(centred.samples[i].accel_m_s2);
    let speed = std::f64::consts::PI;
    // Steady: inwards, w^2 r.
    let steady = added(2_500) - Vector3::new(-speed * speed * 0.02, 0.0, 0.0);
    assert!(steady.norm() < 1e-3, "{steady}");
    // In the middle of the ramp w' = 1.5 w / ramp, and w is half of the full speed; z x (x r) = y.
    let ramp = added(1_150) - Vector3::new(-0.25 * speed * speed * 0.02, 1.5 * speed / 3.0 * 0.02, 0.0);
    assert!(ramp.norm() < 1e-3, "{ramp}");
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

#[test]
fn full_scales_clip_and_flag_and_steps_round() {
    let mut scenario = Scenario { duration_s: 60.0, ..Scenario::default() };
    scenario.accel.full_scale_g = Some(2.0);
    scenario.gyro.full_scale_deg_s = Some(250.0);
    scenario.mag.resolution_ut = Some(0.5);
    let (trace, _) = simulate(&scenario, 1);
    let full_scale = trace.keys.accel_full_scale_m_s2.unwrap();
    let clipped = trace.samples.iter().filter(|s| s.flags.contains(SampleFlags::ACCEL_CLIPPED)).count();
    assert!(clipped > 10);
    assert!(trace.samples.iter().any(|s| s.flags.contains(SampleFlags::GYRO_CLIPPED)));
    for sample in &trace.samples {
        let at_full_scale = sample.accel_m_s2.iter().any(|&x| f64::from(x).abs() >= full_scale);
        assert_eq!(at_full_scale, sample.flags.contains(SampleFlags::ACCEL_CLIPPED));
        assert!(sample.accel_m_s2.iter().all(|&x| f64::from(x).abs() <= full_scale));
        assert!(sample.mag_ut.iter().all(|&x| (x * 2.0).fract() == 0.0));
    }
}

#[test]
fn the_command_writes_a_trace_that_reads_back() {
    let directory = tempfile::tempdir().unwrap();
    let (scenario, output) = (directory.path().join("short.toml"), directory.path().join("short.csv.gz"));
    std::fs::write(&scenario, "duration_s = 15.0\n[rotation]\nmean_rpm = 60\n").unwrap();
    mwd::simulate::run(&SimulateArgs { scenario: scenario.clone(), output: Some(output.clone()), seed: Some(4) })
        .unwrap();
    let read = Trace::read(&output).unwrap();
    let simulated = simulate(&Scenario::read(&scenario).unwrap(), 4).0;
    assert_eq!(read.samples.len(), 1_501);
    for (a, b) in read.samples.iter().zip(&simulated.samples) {
        assert_eq!((a.t_us, a.gyro_rad_s, a.accel_m_s2, a.mag_ut), (b.t_us, b.gyro_rad_s, b.accel_m_s2, b.mag_ut));
    }
    assert!(attitude(&read, 1_400).angle_to(&attitude(&simulated, 1_400)) < 1e-6);
}

#[test]
fn a_scenario_that_cannot_be_used_says_why() {
    let directory = tempfile::tempdir().unwrap();
    let message = |text: &str| {
        let path = directory.path().join("bad.toml");
        std::fs::write(&path, text).unwrap();
        Scenario::read(&path).unwrap_err().to_string()
    };
    assert!(message("[rotation]\nrpm = 30").contains("unknown field `rpm`"));
    assert!(message("duration_s = \"long\"").contains("line 1"));
    assert!(message("duration_s = nan").contains("duration_s must be"));
    assert!(message("oversampling = 3").contains("oversampling must be even"));
    assert!(message("[gyro]\np = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]").contains("gyro.p must be"));
    let missing = Scenario::read(&directory.path().join("none.toml")).unwrap_err();
    assert!(matches!(missing, ScenarioError::Read { .. }) && missing.to_string().contains("none.toml"));
    let path = directory.path().join("empty.toml");
    std::fs::write(&path, "").unwrap();
    assert_eq!(Scenario::read(&path).unwrap(), Scenario::default());
}
