//! `docs/json.md` names every field of a real result, and no field that there is not.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "rig/mod.rs"]
mod rig;

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use serde_json::Value;

use rig::json_fields::{fields, part};

/// The result of a command with `--json`.
fn result(arguments: &[&str], folder: &Path) -> Value {
    let file = folder.join("result.json");
    let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
    let output = command.args(arguments).arg("--json").arg(&file).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn every_field_of_a_result_is_documented_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let traces = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces");
    let trace = |name: &str| traces.join(name).to_str().unwrap().to_owned();
    let (magnet, plain) = (trace("broad_35_attached_magnet_63s.csv.gz"), trace("multipos_mpu9150_imu0.csv.gz"));
    let fast = trace("broad_06_fast_rotation_110s.csv.gz");
    // A tool that rests and turns, so that there are surveys.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scenario = testbed::simulate::Scenario::read(&root.join("scenarios/drilling_45deg.toml")).unwrap();
    let drilled = folder.path().join("drilled.csv");
    testbed::simulate::simulate(&testbed::simulate::Scenario { duration_s: 70.0, ..scenario }, 1)
        .0
        .write(&drilled)
        .unwrap();
    let drilled = drilled.to_str().unwrap();
    let mut found = BTreeSet::new();
    for arguments in [
        vec!["replay", &magnet, "--explain"],
        vec!["replay", &fast, "--hold-out", "0.5"],
        vec!["replay", &plain],
        vec!["replay", drilled],
        vec!["diagnose", &magnet],
        vec!["diagnose", &fast, "--against-reference"],
    ] {
        fields(&result(&arguments, folder.path()), "", &mut found);
    }

    let mut documented = part("The JSON result");
    // These are `null`, or objects whose fields stand below.
    for whole in ["reference", "diagnosis.remainder"] {
        assert!(documented.remove(whole), "{whole}");
        found.remove(whole);
    }
    assert_eq!(found, documented);
}

#[test]
fn every_field_of_a_run_of_surveys_is_documented_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/surveys/forty_stations");
    let [stations, settings] = ["csv", "toml"].map(|end| run.with_extension(end).to_str().unwrap().to_owned());
    let result = result(&["survey", &stations, "--run", &settings], folder.path());
    assert_eq!(result["schema"], "meerkat-mwd-survey/1");
    assert_eq!(result["stations"].as_array().unwrap().len(), 40);
    let mut found = BTreeSet::new();
    fields(&result, "", &mut found);
    assert_eq!(found, part("The JSON of a run of surveys"));
}
