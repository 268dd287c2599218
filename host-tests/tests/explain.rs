//! `replay --explain`: what moved P, the evidence of the widths, and P against a known one.
#![allow(clippy::unwrap_used, missing_docs)]

mod rig;

use std::path::Path;

use meerkat_mwd::SampleFlags;
use serde_json::Value;
use tempfile::TempDir;
use testbed::{
    simulate::{Scenario, simulate},
    trace::Trace,
};

use rig::{files::scenario, program::mwd};

fn drilled() -> Trace {
    simulate(&Scenario { duration_s: 60.0, ..scenario("drilling_45deg") }, 1).0
}

/// Printed text, and the explanation of the last window.
fn explained(trace: &Trace) -> (String, Value) {
    let directory = TempDir::new().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    trace.write(Path::new(&path("trace.csv.gz"))).unwrap();
    let arguments = ["replay", &path("trace.csv.gz"), "--explain", "--json", &path("result.json")];
    let output = mwd(&arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let result: Value = serde_json::from_slice(&std::fs::read(path("result.json")).unwrap()).unwrap();
    let windows = result["identification"]["windows"].as_array().unwrap();
    (String::from_utf8(output.stdout).unwrap(), windows.last().unwrap()["explanation"].clone())
}

#[test]
fn a_window_says_what_moved_p_what_the_widths_are_worth_and_how_far_p_is_from_the_truth() {
    let (text, window) = explained(&drilled());
    for head in ["evidence", "field", "velocity", "position", "rest", "NEES / 9", "against one the simulator's"] {
        assert!(text.contains(head), "{head}: {text}");
    }
    let moved = |kind: &str| window["moved_deg_per_turn"][kind].as_f64().unwrap();
    // The error is 2 to 5 %, and 1 % is 3.6 deg in a turn.
    assert!(moved("all") > 5.0 && moved("field") > 1.0, "{window}");
    // Gravity speaks through the bounds of velocity and position.
    assert!(moved("velocity") + moved("position") > 1.0, "{window}");
    assert!(window["nees_of_p"].as_f64().unwrap() < 4.0, "{window}");
    // The simulator's sensors are better than any data sheet.
    assert!(window["evidence_of_widths"].as_f64().unwrap() > 3.0, "{window}");
    assert!(window["evidence_of_width"]["magnetometer_matrix"].as_f64().unwrap() > 3.0, "{window}");
}

#[test]
fn a_magnetometer_that_is_silent_moves_nothing() {
    let mut trace = drilled();
    trace.samples.iter_mut().for_each(|sample| sample.flags.insert(SampleFlags::MAG_MISSING));
    let (_, window) = explained(&trace);
    assert_eq!(window["moved_deg_per_turn"]["field"].as_f64(), Some(0.0));
    assert!(window["moved_deg_per_turn"]["all"].as_f64().unwrap() > 1.0, "{window}");
}

#[test]
fn a_reference_attitude_stands_in_for_the_truth_and_without_either_there_is_no_nees() {
    let mut trace = drilled();
    trace.keys.true_gyro_p = None;
    let (text, window) = explained(&trace);
    assert!(text.contains("against one from the reference attitude"), "{text}");
    assert!(window["nees_of_p"].as_f64().unwrap() < 4.0, "{window}");
    trace.reference.clear();
    let (text, window) = explained(&trace);
    assert!(text.contains("neither a reference nor a simulator's truth"), "{text}");
    assert!(window["nees_of_p"].is_null() && !window["moved_deg_per_turn"].is_null(), "{window}");
}
