//! What all commands share: `-` for the standard input and output, `--quiet` anywhere, completions.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "rig/mod.rs"]
mod rig;

use std::{
    io::Write,
    process::{Command, Output, Stdio},
};

use rig::{files::scenario_path, program::mwd};
use serde_json::Value;
use tempfile::TempDir;

/// Output of the program with bytes on its standard input.
fn piped(arguments: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(input).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{output:?}");
    output
}

/// A scenario of 70 s.
fn scenario(folder: &TempDir) -> String {
    let text = std::fs::read_to_string(scenario_path("drilling_45deg")).unwrap();
    let path = folder.path().join("short.toml");
    std::fs::write(&path, text.replace("duration_s = 425.0", "duration_s = 70.0")).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A trace that never was a file flies as the file does, and the result is the only thing on the standard output.
#[test]
fn a_pipe_is_a_file() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scenario = scenario(&folder);
    let (trace, json, attitude) = (at("trace.csv"), at("result.json"), at("attitude.csv"));
    assert!(mwd(&["simulate", &scenario, "-o", &trace, "--seed", "5"]).status.success());
    let simulated = piped(&["simulate", "-", "-o", "-", "--seed", "5"], &std::fs::read(&scenario).unwrap());
    assert_eq!(simulated.stdout, std::fs::read(&trace).unwrap());
    assert!(String::from_utf8_lossy(&simulated.stderr).contains("true gyro model"));

    assert!(mwd(&["replay", &trace, "--json", &json, "--attitude", &attitude]).status.success());
    let flown = piped(&["replay", "-", "--json", "-"], &simulated.stdout);
    let mut there: Value = serde_json::from_slice(&flown.stdout).unwrap();
    let mut here: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    assert_eq!(there["trace"]["path"].take(), Value::from("-"));
    here["trace"]["path"].take();
    assert_eq!(there, here);
    let flown = piped(&["replay", "-", "--attitude=-"], &simulated.stdout);
    assert_eq!(flown.stdout, std::fs::read(&attitude).unwrap());

    let imported = piped(&["import", "-", "-o", "-"], &simulated.stdout);
    assert!(imported.stdout.starts_with(b"# source"), "{:?}", String::from_utf8_lossy(&imported.stdout));
    let batch = piped(&["batch", "@-", "-o", &at("all.parquet")], trace.as_bytes());
    assert!(String::from_utf8_lossy(&batch.stdout).starts_with("1 recordings: 1 flown"), "{batch:?}");
}

/// The result says what made it: version, configuration and seed, and the surveys that were taken.
#[test]
fn the_result_says_what_made_it() {
    let folder = TempDir::new().unwrap();
    let scenario = scenario(&folder);
    let trace = piped(&["simulate", &scenario, "-o", "-"], b"").stdout;
    let result = piped(&["replay", "-", "--seed", "7", "--json", "-"], &trace).stdout;
    let result: Value = serde_json::from_slice(&result).unwrap();
    assert_eq!((&result["version"], &result["seed"]), (&Value::from(env!("CARGO_PKG_VERSION")), &Value::from(7)));
    assert_eq!(result["configuration"]["sample_period_us"], Value::from(10_000));
    let surveys = result["surveys"].as_array().unwrap();
    assert!(surveys.iter().any(|survey| survey["kind"] == "rotating"), "{surveys:?}");
    let inclination = surveys[0]["inclination_deg"].as_f64().unwrap();
    assert!((inclination - 45.0).abs() < 1.0, "{inclination}");
}

#[test]
fn a_quiet_run_tells_nothing_wherever_the_option_stands() {
    let folder = TempDir::new().unwrap();
    let scenario = scenario(&folder);
    let trace = folder.path().join("trace.csv.gz");
    let trace = trace.to_str().unwrap();
    for arguments in [
        ["--quiet", "simulate", &scenario, "-o", trace],
        ["simulate", "-q", &scenario, "-o", trace],
        ["simulate", &scenario, "-o", trace, "--quiet"],
    ] {
        let output = mwd(&arguments);
        assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty(), "{output:?}");
    }
    assert!(mwd(&["-q", "replay", trace]).stdout.is_empty());
    let refused = mwd(&["-q", "replay", "none.csv"]);
    assert!(refused.status.code() == Some(2) && !refused.stderr.is_empty());
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = String::from_utf8(mwd(&["completions", shell]).stdout).unwrap();
        assert!(script.contains("replay") && script.contains("hold-out"), "{shell}");
    }
}
