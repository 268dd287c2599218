//! Features that all commands share: `-` for the standard input and output, `--quiet` anywhere, completions.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "rig/mod.rs"]
mod rig;

use std::{
    io::Write,
    process::{Command, Output, Stdio},
};

use rig::{
    files::{ATTACHED_MAGNET, FAST_ROTATION, recording_path, scenario_path},
    program::mwd,
};
use serde_json::Value;
use tempfile::TempDir;

const STATIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/surveys/forty_stations.csv");
const SETTINGS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/surveys/forty_stations.toml");

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

    // Every other result is the same through a pipe, too.
    for option in ["--rates", "--surveys", "--dynamics", "--burst"] {
        let file = at("result.csv");
        assert!(mwd(&["replay", &trace, option, &file]).status.success());
        let flown = piped(&["replay", "-", option, "-"], &simulated.stdout);
        assert_eq!(flown.stdout, std::fs::read(&file).unwrap(), "{option}");
    }
    let run = ["survey", STATIONS, "--run", SETTINGS, "--plain"];
    let file = at("plain.csv");
    assert!(mwd(&[&run[..], &[&file]].concat()).status.success());
    assert_eq!(piped(&[&run[..], &["-"]].concat(), b"").stdout, std::fs::read(&file).unwrap());

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

/// A reader that has what it wanted closes the pipe; a full disk is an error that names the output.
#[test]
fn a_standard_output_that_takes_nothing_is_no_defect() {
    let recording = recording_path(ATTACHED_MAGNET);
    let recording = recording.to_str().unwrap();
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (table, page) = (at("all.parquet"), at("fleet.html"));
    assert!(mwd(&["batch", recording, "-o", &table]).status.success());
    // The last is the main job, which tells before it flies.
    let commands: [(&[&str], &str); 8] = [
        (&["field", "--latitude", "60.4", "--longitude", "5.3", "--date", "2026-06-01"], "standard output"),
        (&["completions", "bash"], "standard output"),
        (&["survey", STATIONS, "--run", SETTINGS], "standard output"),
        (&["survey", STATIONS, "--run", SETTINGS, "--json", "-"], "-"),
        (&["replay", recording], "standard output"),
        (&["replay", recording, "--json", "-"], "-"),
        (&["fleet", &table, "--html", &page], "standard output"),
        (&[], "standard output"),
    ];
    let with = |arguments: &[&str], out: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        let output = command.args(arguments).stdout(out).stderr(Stdio::piped()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for (arguments, named) in commands {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let (status, said) = with(arguments, writer.into());
        assert!(
            status == Some(0) && !said.lines().any(|line| line.starts_with("error: ")),
            "{arguments:?}: {status:?} {said}"
        );
        let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else { continue };
        let (status, said) = with(arguments, full.into());
        let error = format!("error: {named}: cannot be written: ");
        assert!(status == Some(2) && said.contains(&error), "{arguments:?}: {status:?} {said}");
    }
}

/// Each error says what can be done about it; the parser of the command line points at the help.
#[test]
fn every_error_ends_with_a_next_step() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (recording, out) = (recording_path(ATTACHED_MAGNET), at("out.parquet"));
    let recording = recording.to_str().unwrap();
    let (nowhere, none) = (at("file/report.html"), at("none"));
    std::fs::write(at("file"), "[[bin]]\nname = 1\n").unwrap();
    let file = at("file");
    let wrong: [&[&str]; 22] = [
        &["monitor", "/dev/none"],
        &["monitor", &file, "--once"],
        &["record", "/dev/none", "-o", &at("trace.csv")],
        &["command", "/dev/none", "self-test"],
        &["command", "/dev/none", "erase", "models"],
        &["command", "/dev/none", "--key", &none, "erase", "models"],
        &["command", "/dev/none", "configure", &none],
        &["replay", recording, "--config", &none],
        &["replay", recording, "--config", &file],
        &["replay", recording, "--html", &nowhere],
        &["replay", recording, "--hold-out", "3"],
        &["replay", &none],
        &["replay", recording, "--model", &none],
        &["fleet", &none],
        &["fleet", &file],
        &["batch", &at("*.nothing"), "-o", &out],
        &["survey", &none],
        &["simulate", &none],
        &["simulate", &file],
        &["import", &file, "-o", &at("imported.csv")],
        &["bench", "--only", "nothing"],
        &["field", "--latitude", "100", "--longitude", "0", "--date", "2026-01-01"],
    ];
    for arguments in wrong {
        let output = mwd(arguments);
        assert!(!output.status.success(), "{arguments:?}");
        let said = String::from_utf8(output.stderr).unwrap();
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with("next: ") || last.contains("try '--help'"), "{arguments:?}: {said}");
        assert!(said.starts_with("error: ") && !said.contains('\u{1b}'), "{arguments:?}: {said}");
    }
}

/// In a pipe each line says by itself what it shows, and there are no colours; at a terminal there are tables.
#[test]
fn tables_are_for_terminals() {
    let recording = recording_path(FAST_ROTATION);
    let recording = recording.to_str().unwrap();
    let piped = String::from_utf8(mwd(&["replay", recording]).stdout).unwrap();
    let line = piped.lines().find(|line| line.starts_with("scores   whole trace, rotation over 2 s, deg rms: "));
    assert!(line.is_some_and(|line| line.contains("uncompensated ") && line.contains(", flown ")), "{piped}");
    let p = piped.lines().find(|line| line.starts_with("final P  ")).unwrap();
    assert_eq!(p.matches("+-").count(), 9, "{p}");
    assert!(piped.starts_with("verdict  ") && !piped.contains('\u{1b}'), "{piped}");
    // A terminal by `script`, which is of every Debian.
    let command = format!("{} replay {recording}", env!("CARGO_BIN_EXE_mwd"));
    let Ok(output) = Command::new("script").args(["-qec", &command, "/dev/null"]).stdin(Stdio::null()).output() else {
        println!("SKIPPED: no `script`");
        return;
    };
    let shown = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        shown.contains('\u{1b}') && shown.contains("uncompensated    bias only    12 param.        flown"),
        "{shown}"
    );
    assert!(shown.lines().any(|line| line.contains("final P ") && line.matches("+-").count() == 3), "{shown}");
}

/// A header without rows, or a zero with a minus, would tell of nothing.
#[test]
fn what_there_is_not_is_not_told() {
    let recording = recording_path(ATTACHED_MAGNET);
    let recording = recording.to_str().unwrap();
    for command in ["replay", "diagnose"] {
        let told = String::from_utf8(mwd(&[command, recording]).stdout).unwrap();
        for line in told.lines() {
            assert!(!line.starts_with("scores   whole trace  "), "{told}");
            let is_zero = |word: &str| {
                let digits = word.trim_end_matches([',', ';', ')']).strip_prefix('-');
                digits.is_some_and(|zero| zero.contains('0') && zero.chars().all(|c| c == '0' || c == '.'))
            };
            assert!(!line.split([' ', '(']).any(is_zero), "{line}");
        }
    }
}
