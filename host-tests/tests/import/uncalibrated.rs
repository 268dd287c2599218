//! A magnetometer without a calibration is told where the recording is read and where it is flown.

use mwd::import::Verdict;
use serde_json::Value;
use tempfile::TempDir;

use crate::{
    files::{imported, original, si, written},
    rig::program::mwd,
};

/// A hard iron of half of the field, on the axis across which the hand turns most.
const HARD_IRON_UT: f64 = 22.0;

fn with_hard_iron() -> String {
    si([|v| v, |v| v, |[x, y, z]| [x + HARD_IRON_UT, y - HARD_IRON_UT, z]])
}

#[test]
fn a_spread_of_the_field_that_no_reference_suits_is_told_with_the_fix() {
    let folder = TempDir::new().unwrap();
    let of_field = |text: &str| {
        let told = imported(&[written(&folder, "log.csv", text)]);
        told.findings.iter().find(|finding| finding.told.starts_with("|B|")).cloned().unwrap()
    };
    let sound = of_field(&si([|v| v; 3]));
    assert!(sound.verdict == Verdict::Fine && sound.told.contains("nine readings of ten from 4"), "{}", sound.told);
    let spread = of_field(&with_hard_iron());
    assert_eq!(spread.verdict, Verdict::Note, "{}", spread.told);
    assert!(spread.told.contains("nine readings of ten from") && spread.told.contains("10 %"), "{}", spread.told);
    assert!(spread.fix.unwrap().contains("`mwd calibrate`"));
}

#[test]
fn a_flight_without_the_field_says_so_in_text_json_and_page() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let source = written(&folder, "log.csv", &with_hard_iron());
    let (trace, json, page) = (at("trace.csv.gz"), at("result.json"), at("page.html"));
    let import = mwd(&["import", source.to_str().unwrap(), "-o", &trace]);
    assert!(import.status.success(), "{}", String::from_utf8_lossy(&import.stdout));
    let flown = mwd(&["replay", &trace, "--json", &json, "--html", &page]);
    assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
    let text = String::from_utf8(flown.stdout).unwrap();
    let note = text.lines().find(|line| line.starts_with("note     in ")).unwrap();
    assert!(note.contains("% of the motion the field was not used") && note.contains("`mwd calibrate`"), "{note}");
    // The recording is shorter than a window.
    let verdict = text.lines().next().unwrap();
    assert!(verdict.starts_with("verdict") && verdict.contains("of the motion the field was not used"), "{verdict}");
    let result: Value = serde_json::from_str(&std::fs::read_to_string(&json).unwrap()).unwrap();
    let is_told = |note: &Value| note.as_str().unwrap().contains("the field was not used");
    assert!(result["trace"]["notes"].as_array().unwrap().iter().any(is_told), "{}", result["trace"]["notes"]);
    assert!(std::fs::read_to_string(&page).unwrap().contains("of the motion the field was not used"));
    // The field of the recording as it is, is used.
    original().write(trace.as_ref()).unwrap();
    let text = String::from_utf8(mwd(&["replay", &trace]).stdout).unwrap();
    assert!(text.contains("verdict") && !text.contains("the field was not used"), "{text}");
}
