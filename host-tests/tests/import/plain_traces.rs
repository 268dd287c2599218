//! Units, signs and axes of a trace that is flown as it is: what cannot be is refused by name, and what is
//! only hard is not.

use meerkat_mwd::Sample;
use mwd::import::plausible::checked;
use serde_json::Value;
use tempfile::TempDir;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Effects, Scenario, simulate},
    trace::{
        Trace,
        recordings::{bundled, given},
    },
};

use crate::{
    files::original,
    rig::{files::scenario, program::mwd},
};

fn drilled(seconds: f64, seed: u64) -> Trace {
    simulate(&Scenario { duration_s: seconds, ..scenario("drilling_45deg") }, seed).0
}

/// The trace with every sample changed.
fn changed(trace: &Trace, change: impl Fn(&mut Sample)) -> Trace {
    let mut trace = trace.clone();
    trace.samples.iter_mut().for_each(change);
    trace
}

/// Errors of the trace, as a flight would be told.
fn wrong(trace: &Trace) -> Vec<String> {
    let (mut trace, mut config) = (trace.clone(), of_trace(trace));
    let refused = checked(&mut trace, &mut config, false);
    assert_eq!(refused.is_err(), !trace.wrong.is_empty());
    trace.wrong
}

fn scaled(reading: &mut [f32; 3], factor: f32) {
    reading.iter_mut().for_each(|x| *x *= factor);
}

#[test]
fn a_wrong_unit_or_sign_is_named_with_the_fix() {
    let drilled = drilled(80.0, 3);
    type Case = (&'static str, &'static str, fn(&mut Sample));
    let cases: [Case; 8] = [
        ("the field dips", "an accelerometer at rest reads up", |s| scaled(&mut s.accel_m_s2, -1.0)),
        ("|B|", "unit = \"gauss\" in [mag]", |s| scaled(&mut s.mag_ut, 0.01)),
        ("|B|", "unit = \"nT\" in [mag]", |s| scaled(&mut s.mag_ut, 1_000.0)),
        ("times the gyro's rate", "unit = \"deg/s\" in [gyro]", |s| scaled(&mut s.gyro_rad_s, 57.295_78)),
        ("|a|", "unit = \"g\" in [accel]", |s| scaled(&mut s.accel_m_s2, 1.0 / 9.806_65)),
        ("axes of the gyro are wrong", "\"-gz\"", |s| s.gyro_rad_s[2] = -s.gyro_rad_s[2]),
        ("axes of the gyro are wrong", "\"-gy\"", |s| s.gyro_rad_s[1] = -s.gyro_rad_s[1]),
        ("are wrong: ", "columns = ", |s| s.mag_ut[1] = -s.mag_ut[1]),
    ];
    for trace in [&drilled, original()] {
        for (told, fix, change) in cases {
            // The recording's header has no dip: nothing says which way is up.
            if trace.keys.dip_deg.is_none() && told == "the field dips" {
                continue;
            }
            let wrong = wrong(&changed(trace, change));
            assert!(wrong.iter().any(|line| line.contains(told) && line.contains(fix)), "{told}: {wrong:#?}");
        }
    }
    // A tool whose axis points up the hole while the field points up, too, is upside down without any header.
    let mut unknown = changed(&drilled, |s| scaled(&mut s.accel_m_s2, -1.0));
    unknown.keys.dip_deg = None;
    unknown.keys.latitude_deg = None;
    assert!(wrong(&unknown).iter().any(|line| line.contains("points up")), "{:?}", wrong(&unknown));
}

/// Recordings, drilling with every kind of error that the simulator draws, and rests are as they are.
#[test]
fn nothing_is_found_where_nothing_is_wrong() {
    for path in bundled().unwrap().into_iter().chain(given().unwrap()) {
        let trace = Trace::read(&path).unwrap();
        assert_eq!(wrong(&trace), [""; 0], "{}", path.display());
    }
    for name in
        ["drilling_45deg", "drilling_vertical", "turntable_30hz", "real_drilling_30hz", "simulated_drilling_30hz"]
    {
        for seed in 1..=3 {
            let trace = simulate(&Scenario { duration_s: 90.0, ..scenario(name) }, seed).0;
            assert_eq!(wrong(&trace), [""; 0], "{name} {seed}");
        }
    }
    assert_eq!(wrong(&drilled(9.0, 1)), [""; 0]);
    // The largest of the library's effects, one after the other.
    let effects = [
        Effects { mag_lag_ms: 15.0, gyro_lag_ms: 10.0, accel_lag_ms: 5.0, ..Effects::default() },
        Effects { hard_iron_ut: [20.0, -15.0, 30.0], ..Effects::default() },
        Effects { accel_matrix: [[0.05, 0.0, 0.0], [0.0, -0.05, 0.0], [0.0, 0.0, 0.05]], ..Effects::default() },
        Effects { lever_arm_mm: [100.0, 50.0, 200.0], bias_step_deg_s: [3.0, -3.0, 3.0], ..Effects::default() },
        Effects { mag_matrix: [[0.1, 0.05, 0.0], [0.05, -0.1, 0.0], [0.0, 0.0, 0.1]], ..Effects::default() },
    ];
    for (number, effects) in effects.into_iter().enumerate() {
        let scenario = Scenario { duration_s: 90.0, effects, ..scenario("drilling_45deg") };
        assert_eq!(wrong(&simulate(&scenario, 1).0), [""; 0], "effects {number}");
    }
}

/// Readings that the configuration's models bring into tool axes are looked at as these models leave them.
#[test]
fn the_configurations_sensor_models_come_first() {
    let mut trace = changed(&drilled(80.0, 5), |s| {
        for v in [&mut s.accel_m_s2, &mut s.mag_ut] {
            *v = [v[1], -v[0], v[2]];
        }
    });
    assert!(!wrong(&trace).is_empty());
    let mut config = of_trace(&trace);
    let turned = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    config.accel.matrix = turned;
    config.mag.matrix = turned;
    assert!(checked(&mut trace, &mut config, false).is_ok(), "{:?}", trace.wrong);
}

#[test]
fn replay_and_diagnose_refuse_and_a_forced_flight_identifies_nothing() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (trace, json, surveys, table) = (at("k.csv"), at("k.json"), at("k.surveys.csv"), at("k.parquet"));
    changed(&drilled(80.0, 3), |s| scaled(&mut s.accel_m_s2, -1.0)).write(trace.as_ref()).unwrap();
    for command in ["replay", "diagnose", "survey"] {
        let output = mwd(&[command, &trace]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("sign of all axes of the accelerometer") && told.contains("--force"), "{told}");
    }
    assert!(mwd(&["replay", &trace, "--force", "--json", &json, "--surveys", &surveys]).status.success());
    let result: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let windows = result["identification"]["windows"].as_array().unwrap();
    assert!(windows.iter().all(|window| window["accepted"] == false), "{windows:?}");
    assert_eq!(result["diagnosis"]["effects"].as_array().unwrap().len(), 0);
    assert!(result["trace"]["wrong"][0].as_str().unwrap().contains("dips"));
    let surveys = std::fs::read_to_string(&surveys).unwrap();
    assert!(surveys.lines().count() > 1 && !surveys.contains(",good,"), "{surveys}");
    let batch = mwd(&["batch", &trace, "-o", &table]);
    assert!(String::from_utf8_lossy(&batch.stdout).contains("1 bad"), "{batch:?}");
}
