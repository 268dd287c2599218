//! `docs/json.md` names every field of a real result, and no field that there is not.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use serde_json::Value;

/// Fields whose members have names of their own: parameters of an effect, fields of the configuration.
const NAMED: [&str; 3] = ["diagnosis.effects[].parameters", "diagnosis.effects[].sigma", "configuration"];

/// Lists of objects: an empty one says nothing of their fields.
const OBJECTS: [&str; 4] = ["identification.windows", "diagnosis.effects", "diagnosis.remainder.goes_with", "surveys"];

/// Adds the paths of all fields of `value`, which stands at `path`.
fn fields(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) if NAMED.contains(&path) => {
            assert!(!members.is_empty(), "{path}");
            found.insert(format!("{path}.*"));
        }
        Value::Object(members) => {
            for (name, member) in members {
                let separator = if path.is_empty() { "" } else { "." };
                fields(member, &format!("{path}{separator}{name}"), found);
            }
        }
        Value::Array(elements) if elements.iter().any(Value::is_object) => {
            elements.iter().for_each(|element| fields(element, &format!("{path}[]"), found));
        }
        Value::Array(elements) if elements.is_empty() && OBJECTS.contains(&path) => {}
        _ => {
            found.insert(path.to_owned());
        }
    }
}

/// Fields that a part of `docs/json.md` names.
fn documented(part: &str) -> BTreeSet<String> {
    let rows = part.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
    rows.map(|(field, _)| field.to_owned()).collect()
}

/// `docs/json.md`: of a flight, and of a run of surveys.
fn parts() -> [String; 2] {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/json.md")).unwrap();
    let (flight, run) = page.split_once("\n# The JSON of a run of surveys\n").unwrap();
    [flight, run].map(str::to_owned)
}

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

    let mut documented = documented(&parts()[0]);
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
    assert_eq!(found, documented(&parts()[1]));
}
