//! The command line as other programs use it: exit statuses, files, schema, and the same bytes twice.
#![allow(clippy::unwrap_used, missing_docs)]

mod rig;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Output,
};

use meerkat_mwd::{
    Sample, SampleFlags,
    compensation::{ActiveEffects, GyroModel, effects::LIBRARY},
    storage::{StoreReason, StoredModel, fingerprint},
};
use serde_json::Value;
use tempfile::TempDir;
use testbed::{
    flight::configuration::of_trace,
    simulate::{Scenario, simulate},
    trace::{Keys, Trace},
};

use rig::page::{is_whole, unbalanced};
use rig::{
    files::{FAST_ROTATION, recording_path},
    program::mwd,
};

fn error_of(arguments: &[&str], status: i32) -> String {
    let output = mwd(arguments);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {output:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// Ten seconds at 200 Hz: a slow turn about gravity, one second of it without magnetometer, three readings
/// clipped, a reference for the second half.
fn trace() -> Trace {
    let sample = |i: u64| {
        let mut flags = SampleFlags::TEMPERATURE_MISSING;
        flags.set(SampleFlags::MAG_MISSING, (400..600).contains(&i));
        let (sine, cosine) = (0.5 * i as f64 / 200.0).sin_cos();
        let mag_ut = if flags.contains(SampleFlags::MAG_MISSING) {
            [0.0; 3]
        } else {
            [20.0 * cosine as f32, -20.0 * sine as f32, 43.0]
        };
        let rate = if (700..703).contains(&i) { 35.0 } else { 0.5 };
        Sample {
            t_us: 1_000_000 + 5_000 * i,
            gyro_rad_s: [0.0, 0.0, rate],
            accel_m_s2: [0.0, 0.0, -9.81],
            mag_ut,
            flags,
            ..Sample::default()
        }
    };
    let keys = Keys { gyro_full_scale_rad_s: Some(34.9), gravity_m_s2: Some(9.81), ..Keys::default() };
    let samples: Vec<Sample> = (0..2_000).map(sample).collect();
    let reference = (0..2_000).map(|i| (i >= 1_000).then_some([1.0, 0.0, 0.0, 0.0])).collect();
    Trace { keys, samples, reference, ..Trace::default() }
}

fn written(directory: &TempDir) -> PathBuf {
    let path = directory.path().join("trace.csv.gz");
    trace().write(&path).unwrap();
    path
}

fn replayed(trace: &Path, into: &Path, more: &[&str]) -> (Output, [String; 3]) {
    fs::create_dir_all(into).unwrap();
    let files = ["attitude.csv", "rates.csv", "result.json"].map(|name| into.join(name));
    let [attitude, rates, json] = files.each_ref().map(|path| path.to_str().unwrap());
    let mut arguments =
        vec!["replay", trace.to_str().unwrap(), "--attitude", attitude, "--rates", rates, "--json", json];
    arguments.extend(more);
    let output = mwd(&arguments);
    assert!(output.status.success(), "{output:?}");
    (output, files.map(|path| fs::read_to_string(path).unwrap()))
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let directory = TempDir::new().unwrap();
    let trace = written(&directory);
    let more = ["--hold-out", "0.5", "--seed", "7", "--no-effects"];
    let first = replayed(&trace, &directory.path().join("first"), &more);
    let second = replayed(&trace, &directory.path().join("second"), &more);
    assert_eq!(first, second);
}

#[test]
fn there_is_one_row_per_sample_at_its_time() {
    let directory = TempDir::new().unwrap();
    let (_, [attitude, rates, _]) = replayed(&written(&directory), directory.path(), &[]);
    let samples = trace().samples;
    for (text, header) in [(&attitude, "t_s,qw,qx,qy,qz,inclination_deg,"), (&rates, "t_s,wx,wy,wz")] {
        assert!(text.starts_with(header));
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows.len(), samples.len());
        let cells = text.lines().next().unwrap().split(',').count();
        for (row, sample) in rows.iter().zip(&samples) {
            assert_eq!(row.split(',').count(), cells);
            let t_us = row.split(',').next().unwrap().replace('.', "").parse::<u64>().unwrap();
            assert!(t_us.abs_diff(sample.t_us) < 100_000);
        }
    }
}

#[test]
fn the_result_has_the_schema() {
    let directory = TempDir::new().unwrap();
    let (output, [_, _, json]) = replayed(&written(&directory), directory.path(), &["--hold-out", "0.4"]);
    let result: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(result["schema"], "meerkat-mwd/1");
    let facts = &result["trace"];
    assert!(facts["path"].as_str().unwrap().ends_with("trace.csv.gz"));
    assert_eq!(
        (&facts["samples"], &facts["duration_s"], &facts["rate_hz"]),
        (&2_000.into(), &9.995.into(), &200.0.into())
    );
    assert_eq!(facts["clipped"], 3);
    assert_eq!(facts["gaps"], 0);
    let missing = &facts["missing"];
    assert_eq!((&missing["mag"], &missing["temp"], &missing["reference"]), (&200.into(), &2_000.into(), &1_000.into()));
    let last = &result["identification"]["final"];
    for (name, length) in [("P", 9), ("b_rad_s", 3), ("sigma", 12), ("observable", 12)] {
        assert_eq!(last[name].as_array().unwrap().len(), length, "{name}");
    }
    assert!(last["rank"].is_u64());
    assert!(result["identification"]["windows"].is_array());
    assert_eq!(result["identification"]["hold_out_from_s"], 6.997);
    let diagnosis = &result["diagnosis"];
    assert_eq!(diagnosis["verdict"], "not_enough_excitation", "ten seconds");
    assert_eq!(diagnosis["effects"], Value::Array(Vec::new()));
    for name in ["gravity_deg", "magnetic_deg", "nis"] {
        let pair = diagnosis["residual"][name].as_object().unwrap();
        assert!(pair.contains_key("before") && pair.contains_key("after"));
    }
    assert!(diagnosis["residual"]["nis"].as_object().unwrap().values().all(Value::is_null), "no window was diagnosed");
    assert!(result.as_object().unwrap().contains_key("reference"));
    assert!(output.stderr.is_empty(), "no progress bar in a pipe");
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(summary.lines().count() <= 40 && summary.contains("2000 samples"), "{summary}");
}

#[test]
fn a_trace_shorter_than_a_window_still_flies_and_says_why_nothing_was_identified() {
    let directory = TempDir::new().unwrap();
    let (output, [_, _, json]) = replayed(&written(&directory), directory.path(), &[]);
    let result: Value = serde_json::from_str(&json).unwrap();
    let identification = &result["identification"];
    let windows = identification["windows"].as_array().unwrap();
    let why = windows.first().map_or(&identification["note"], |window| &window["reason"]).as_str().unwrap();
    assert!(String::from_utf8(output.stdout).unwrap().contains(why), "{why}");
    assert_eq!(result["identification"]["final"]["rank"], 0);
    assert_eq!(result["identification"]["final"]["P"][0], 1.0);
}

#[test]
fn without_a_full_scale_the_clipped_count_is_null_not_zero() {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("trace.csv");
    Trace { keys: Keys::default(), ..trace() }.write(&path).unwrap();
    let (_, [_, _, json]) = replayed(&path, directory.path(), &[]);
    assert!(serde_json::from_str::<Value>(&json).unwrap()["trace"]["clipped"].is_null());
}

#[test]
fn every_optimizer_of_the_interface_flies() {
    let directory = TempDir::new().unwrap();
    let trace = written(&directory);
    for optimizer in ["imoa", "moa", "pso", "de", "lm", "ls"] {
        assert!(mwd(&["replay", trace.to_str().unwrap(), "--optimizer", optimizer]).status.success());
    }
}

/// The page of a replay, and the JSON of the same one.
fn page_of(trace: &Path, directory: &TempDir) -> (String, Value) {
    let [page, json] = ["page.html", "result.json"].map(|name| directory.path().join(name));
    let (trace, page, json) = (trace.to_str().unwrap(), page.to_str().unwrap(), json.to_str().unwrap());
    let output = mwd(&["replay", trace, "--html", page, "--json", json]);
    assert!(output.status.success(), "{output:?}");
    let page = fs::read_to_string(page).unwrap();
    assert_eq!(unbalanced(&page), Vec::<String>::new());
    assert!(is_whole(&page));
    (page, serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap())
}

/// Page and JSON say the same: every refusal, and the scores to the digits that the page shows.
#[test]
fn the_page_of_a_recording_tells_its_windows_and_its_scores() {
    let directory = TempDir::new().unwrap();
    let recorded = recording_path(FAST_ROTATION);
    let (page, json) = page_of(&recorded, &directory);
    let windows = json["identification"]["windows"].as_array().unwrap();
    assert!(windows.len() > 1);
    for window in windows {
        let told = window["reason"].as_str().unwrap_or("accepted");
        assert!(page.contains(told), "{told}");
    }
    let attitude = &json["reference"]["attitude_rms_deg"];
    for part in ["total", "heading", "inclination"] {
        let cell = format!(">{:.3}</td>", attitude[part].as_f64().unwrap());
        assert!(page.contains(&cell), "{part}: {cell}");
    }
    for plot in [
        "Inclination",
        "Azimuth",
        "Stated deviations",
        "Errors against the reference",
        "Bias b",
        "Gyro, as read",
        "|B|",
    ] {
        assert!(page.contains(&format!("<h3>{plot}, ")), "{plot}");
    }
}

#[test]
fn the_page_of_a_trace_without_a_window_says_why_there_is_none() {
    let directory = TempDir::new().unwrap();
    let (page, json) = page_of(&written(&directory), &directory);
    assert_eq!(json["identification"]["windows"].as_array().unwrap().len(), 0);
    assert!(page.contains("Nothing was identified") && page.contains("the trace lasts 10.0 s; a window takes 50.0 s"));
}

#[test]
fn usage_errors_end_with_status_2() {
    let directory = TempDir::new().unwrap();
    let trace = written(&directory);
    let trace = trace.to_str().unwrap();
    for bad in ["0", "1", "-0.5", "1.5", "NaN", "half"] {
        let message = error_of(&["replay", trace, &format!("--hold-out={bad}")], 2);
        assert!(message.contains("between 0 and 1"), "{bad}: {message}");
    }
    assert!(error_of(&["replay", trace, "--fast"], 2).contains("--fast"));
    assert!(error_of(&["replay", trace, "--seed", "-1"], 2).contains("-1"));
    assert!(error_of(&["fly", trace], 2).contains("fly"));
    assert!(error_of(&["replay"], 2).contains("TRACE"));
    assert!(error_of(&["replay", trace, "--json", "/nonexistent/result.json"], 2).contains("cannot be written"));
    assert!(error_of(&["replay", trace, "--rates", trace], 2).contains("overwrite the trace"));
    assert!(error_of(&["replay", trace, "--html", trace], 2).contains("overwrite the trace"));
    let result = directory.path().join("result.csv");
    let result = result.to_str().unwrap();
    assert!(error_of(&["replay", trace, "--rates", result, "--attitude", result], 2).contains("overwrite another one"));
    fs::create_dir(directory.path().join("inner")).unwrap();
    let [one, same] = ["new.json", "inner/../new.json"].map(|name| directory.path().join(name));
    let (one, same) = (one.to_str().unwrap(), same.to_str().unwrap());
    assert!(error_of(&["replay", trace, "--json", same, "--html", one], 2).contains("overwrite another one"));
    fs::write(result, "seed = 2").unwrap();
    assert!(
        error_of(&["replay", trace, "--config", result, "--json", result], 2).contains("overwrite the configuration")
    );
    assert!(mwd(&["--help"]).status.success());
}

#[test]
fn a_configuration_file_is_checked_field_by_field() {
    let directory = TempDir::new().unwrap();
    let trace = written(&directory);
    let config = directory.path().join("config.toml");
    let with = |text: &str| {
        fs::write(&config, text).unwrap();
        error_of(&["replay", trace.to_str().unwrap(), "--config", config.to_str().unwrap()], 2)
    };
    assert!(with("[identification]\nwindow = 40").contains("`window`"));
    assert!(with("[identification]\nwindow_s = 400").contains("identification.window_s must be at most 50"));
    assert!(with("[gyro]\nb_rad_s = [1, 2]").contains("gyro.b_rad_s"));
    assert!(with("seed = ").contains("config.toml"));
    let period = with("sample_period_us = 1000");
    assert!(
        period.contains("config.toml: sample_period_us is 1000, but the median step of the trace is 5000"),
        "{period}"
    );
    let missing = directory.path().join("none.toml");
    let message = error_of(&["replay", trace.to_str().unwrap(), "--config", missing.to_str().unwrap()], 2);
    assert!(message.contains("none.toml: cannot be read"));
}

/// The model that flies changes between windows, and with a stored model before the first: P and b at the end are those
/// with which the last rates were made, the residual is of what flew, and the verdict says where it comes from.
#[test]
fn p_and_b_at_the_end_are_those_that_flew() {
    let directory = TempDir::new().unwrap();
    let mut scenario = Scenario { duration_s: 40.0, rest_s: 5.0, ..Scenario::default() };
    scenario.hole.inclination_deg = 45.0;
    let (trace, truth) = simulate(&scenario, 1);
    let path = directory.path().join("short.csv");
    trace.write(&path).unwrap();
    let gyro = GyroModel { b_rad_s: truth.gyro.b_rad_s.map(|b| b + 0.001), ..truth.gyro };
    let model = StoredModel {
        gyro,
        sigma: [0.005; 12],
        effects: ActiveEffects::none(),
        library: fingerprint(&LIBRARY, &of_trace(&trace)),
        temperature_c: None,
        t_us: 1_000_000,
        reason: StoreReason::Command,
    };
    let stored = directory.path().join("model.toml");
    fs::write(&stored, toml::to_string(&model).unwrap()).unwrap();
    for model in [&[][..], &["--model", stored.to_str().unwrap()]] {
        let (output, [_, rates, json]) = replayed(&path, directory.path(), model);
        let result: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(result["identification"]["windows"].as_array().unwrap().len(), 0);
        let last = &result["identification"]["final"];
        let p = |row: usize, column: usize| last["P"][3 * row + column].as_f64().unwrap();
        let rates: Vec<Vec<f64>> =
            rates.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        for (rate, sample) in rates.iter().zip(&trace.samples).rev().take(100) {
            for row in 0..3 {
                let raw = |k: usize| f64::from(sample.gyro_rad_s[k]) - last["b_rad_s"][k].as_f64().unwrap();
                let flown: f64 = (0..3).map(|k| p(row, k) * raw(k)).sum();
                assert!((flown - rate[row + 1]).abs() < 1e-5, "{flown} {rate:?}");
            }
        }
        assert!(p(0, 0) != 1.0);
        let field = &result["diagnosis"]["residual"]["magnetic_deg"];
        assert!(field["after"].as_f64().unwrap() < 0.5 * field["before"].as_f64().unwrap(), "{field}");
        let said = String::from_utf8(output.stdout).unwrap();
        assert!(said.contains("no window has judged: the trace lasts 40.0 s"), "{said}");
    }
}

/// The first sample behind a step of more than ten seconds is refused: it is told, and its row is empty.
#[test]
fn a_refused_sample_has_an_empty_row() {
    let directory = TempDir::new().unwrap();
    let mut trace = trace();
    trace.samples.iter_mut().skip(1_500).for_each(|sample| sample.t_us += 11_000_000);
    let path = directory.path().join("gap.csv");
    trace.write(&path).unwrap();
    let (_, [attitude, rates, json]) = replayed(&path, directory.path(), &[]);
    for (text, commas) in [(&attitude, 12), (&rates, 3)] {
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows.len(), trace.samples.len());
        assert_eq!(rows[1_500], format!("19.500000{}", ",".repeat(commas)));
        assert_eq!(rows.iter().filter(|row| row.ends_with(&",".repeat(commas))).count(), 1);
    }
    let result: Value = serde_json::from_str(&json).unwrap();
    let notes = result["trace"]["notes"].to_string();
    assert!(notes.contains("1 samples refused for their time, the first at 19.500000 s"), "{notes}");
    assert_eq!(result["trace"]["gaps"], 1);
}
