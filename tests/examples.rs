//! The examples are compiled and run, and do what they say.
#![allow(clippy::unwrap_used, missing_docs)]
// Their `main` and what it prints belong to the examples, and each has its own copy of the motion.
#![allow(dead_code, clippy::duplicate_mod)]

#[path = "../examples/attitude_only.rs"]
mod attitude_only;
#[path = "../examples/minimal_pipeline.rs"]
mod minimal_pipeline;
#[path = "../examples/own_cost.rs"]
mod own_cost;
#[path = "../examples/own_effect.rs"]
mod own_effect;
#[cfg(feature = "bus")]
#[path = "../examples/own_imu.rs"]
mod own_imu;
#[cfg(feature = "bus")]
#[path = "../examples/own_sensor.rs"]
mod own_sensor;
#[cfg(feature = "storage")]
#[path = "../examples/stored_model.rs"]
mod stored_model;
#[cfg(feature = "telemetry")]
#[path = "../examples/super_loop.rs"]
mod super_loop;

#[path = "../examples/survey_run.rs"]
mod survey_run;

use meerkat_mwd::compensation::GyroModel;

/// Largest differences of two models: of P, and of b in rad/s.
fn apart(a: &GyroModel, b: &GyroModel) -> [f32; 2] {
    let largest = |a: &[f32], b: &[f32]| {
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, |most, x| if x > most { x } else { most })
    };
    [largest(a.p.as_flattened(), b.p.as_flattened()), largest(&a.b_rad_s, &b.b_rad_s)]
}

/// The gyro is off by up to 6 % and 0.02 rad/s; a window of that motion tells it to a tenth of that.
#[test]
fn the_minimal_pipeline_finds_the_gyros_errors() {
    minimal_pipeline::main().unwrap();
    let [p, b] = apart(&minimal_pipeline::fly().unwrap(), &minimal_pipeline::motion::TRUE);
    assert!(p < 6e-3 && b < 2e-3, "{p} {b}");
}

/// 900 nT along the string turn the azimuth by degrees; 20 stations tell most of it.
#[test]
fn stations_of_a_run_are_corrected_together() {
    survey_run::main().unwrap();
    let [before, after] = survey_run::run().unwrap().map(f32::to_degrees);
    assert!(before > 1.5 && after < 0.3 * before, "{before} {after}");
}

#[cfg(feature = "telemetry")]
#[test]
fn a_super_loop_sends_and_identifies() {
    super_loop::main().unwrap();
    let (bytes, apart) = super_loop::fly().unwrap();
    // 9,000 samples a 100th of a second apart, some 30 bytes each.
    assert!(bytes > 100_000 && apart < 6e-3, "{bytes} {apart}");
}

#[test]
fn the_attitude_filter_runs_alone() {
    attitude_only::main();
    let attitude = attitude_only::filter().unwrap();
    assert!(attitude.sigma_inclination_rad < 0.05 && attitude.sigma_azimuth_rad < 0.1, "{attitude:?}");
}

#[cfg(feature = "storage")]
#[test]
fn a_stored_model_flies_after_the_power_was_off() {
    stored_model::main().unwrap();
    let (stored, restored) = stored_model::after_power_off().unwrap();
    assert_eq!(stored, restored);
    assert!(apart(&restored, &stored_model::motion::TRUE)[0] < 6e-3);
}

#[cfg(feature = "bus")]
#[test]
fn a_sensor_of_ones_own_gives_its_readings_in_the_tools_frame() {
    own_sensor::main().unwrap();
    let fields = own_sensor::fields().unwrap();
    assert!((70..=80).contains(&fields.len()), "{}", fields.len());
    assert!(fields.iter().all(|[x, _, z]| (z + 20.0).abs() < 4.0 && x.abs() < 4.0), "{fields:?}");
}

/// The part needs 135 ms for its start, and its first frames are dropped.
#[cfg(feature = "bus")]
#[test]
fn a_gyro_of_ones_own_gives_samples() {
    own_imu::main().unwrap();
    let samples = own_imu::samples().unwrap();
    assert!((160..=200).contains(&samples.len()), "{}", samples.len());
    for sample in &samples {
        assert!(sample.flags.contains(meerkat_mwd::SampleFlags::MAG_MISSING));
        let [x, y, z] = sample.gyro_rad_s.map(f32::to_degrees);
        assert!((x - 10.0).abs() < 0.5 && y.abs() < 0.5 && z.abs() < 0.5, "{sample:?}");
        assert!((sample.accel_m_s2[2] - 9.81).abs() < 0.1 && (sample.temperature_c - 30.0).abs() < 0.1, "{sample:?}");
    }
}

#[test]
fn an_effect_of_ones_own_is_found_with_its_size() {
    own_effect::main().unwrap();
    let found = own_effect::found().unwrap();
    let [(name, size)] = found.as_slice() else { unreachable!("{found:?}") };
    assert_eq!(*name, "square_of_the_rate");
    assert!((size / own_effect::TRUE - 1.0).abs() < 0.3, "{size}");
}

#[test]
fn the_damped_oscillation_is_found_within_its_noise() {
    own_cost::main().unwrap();
    let found = own_cost::fit().unwrap();
    // Deviations by Cramer-Rao are 0.006 to 0.01: four of them.
    for (found, expected) in found.iter().zip(&own_cost::TRUE) {
        assert!((found - expected).abs() < 0.04, "{found} for {expected}");
    }
}
