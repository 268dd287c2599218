use testbed::simulate::{Effects, HardIronInterval, MountRotation, Scenario, simulate};

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
