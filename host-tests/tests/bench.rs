//! The bench: its bound is a bound, its command line and its JSON are as stated.
#![allow(clippy::unwrap_used, missing_docs)]

use std::process::{Command, Output};

use meerkat_mwd::config::OptimizerKind;
use research::{
    contenders::{Contenders, IMOA, NAMES, TRUE},
    pure_integration::Drift,
};
use serde_json::Value;
use tempfile::TempDir;
use testbed::{
    simulate::{Scenario, simulate},
    study::{
        cramer_rao::{Bound, Vibration},
        one_window::{Run, scenario},
        rms,
    },
};

fn mwd(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mwd")).arg("bench").args(arguments).env("MWD_NO_INSTALL", "1").output().unwrap()
}

/// Two minutes after the window are enough here.
fn drilling(name: &str) -> Scenario {
    Scenario { duration_s: 175.0, ..scenario(name).unwrap() }
}

/// An estimate better than its bound would prove the bound wrong; the margin is for the scatter of 20 seeds.
#[test]
fn no_estimate_beats_the_cramer_rao_bound() {
    for name in ["drilling_vertical", "drilling_45deg"] {
        let mut bounds = Vec::new();
        let mut errors = Vec::new();
        for seed in 0..20 {
            let run = Run::simulate(&drilling(name), seed).unwrap();
            bounds.push(run.bound_deg_s(Vibration::Coloured));
            let fitted =
                [OptimizerKind::Imoa, OptimizerKind::Lm].map(|optimizer| run.identify(optimizer).unwrap().fitted);
            errors.push(fitted.map(|model| run.rate_error_deg_s(&model).unwrap()));
        }
        for search in 0..2 {
            let errors: Vec<f64> = errors.iter().map(|error| error[search]).collect();
            let ratio = rms(&errors) / rms(&bounds);
            println!(
                "{name}: rms of error {:.4}, of the bound {:.4} deg/s, ratio {ratio:.2}",
                rms(&errors),
                rms(&bounds)
            );
            assert!(ratio > 0.8, "{name}: {ratio}");
            // A bound far below every estimate would be no use.
            assert!(ratio < 3.0, "{name}: {ratio}");
        }
    }
}

/// Estimates drawn from the bound have, on average, the error that it states: its map from covariance to rate
/// error is the scorer's.
#[test]
fn the_bound_in_deg_s_is_what_the_scorer_finds_of_estimates_at_the_bound() {
    let run = Run::simulate(&drilling("drilling_45deg"), 3).unwrap();
    let (bound, truth) = (run.bound(Vibration::Coloured.into()), run.true_model());
    let errors: Vec<f64> = (0..300).map(|seed| run.rate_error_deg_s(&bound.draw(&truth, seed)).unwrap()).collect();
    let ratio = rms(&errors) / run.bound_deg_s(Vibration::Coloured);
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

#[test]
fn the_bound_falls_with_the_length_of_the_window_at_least_as_its_root() {
    let scenario = Scenario { duration_s: 101.0, ..scenario("drilling_45deg").unwrap() };
    let (trace, truth) = simulate(&scenario, 2);
    let prior = meerkat_mwd::Config::default().identification;
    let rates = trace.true_rate.as_deref().unwrap();
    let bound = |seconds: usize| {
        let last = seconds * 100;
        let bound = Bound::of_window(&scenario, &trace, &truth, last, &prior, Vibration::Coloured.into());
        bound.rate_error_rad_s(&truth.gyro_at(last), rates)
    };
    // These have 15, 30 and 90 s of drilling; the bias walk keeps the last bound from falling further.
    let [short, middle, long] = [25, 40, 100].map(bound);
    assert!(short / middle > 2_f64.sqrt(), "{short} {middle}");
    assert!(middle / long > 1.3, "{middle} {long}");
}

/// Less knowledge of the noise cannot give a better bound.
#[test]
fn the_bound_rises_when_the_vibrations_colour_is_not_known() {
    for name in ["drilling_vertical", "drilling_45deg"] {
        let run = Run::simulate(&drilling(name), 5).unwrap();
        let [coloured, white] = [Vibration::Coloured, Vibration::White].map(|known| run.bound_deg_s(known));
        assert!(white > 1.02 * coloured && white < 2.0 * coloured, "{name}: {coloured} {white}");
    }
}

/// More noise of any sensor makes the bound worse.
#[test]
fn the_bound_rises_with_every_noise() {
    let bound = |change: fn(&mut Scenario)| {
        let mut scenario = drilling("drilling_45deg");
        change(&mut scenario);
        Run::simulate(&scenario, 4).unwrap().bound_deg_s(Vibration::Coloured)
    };
    let base = bound(|_| {});
    assert!(bound(|s| s.gyro.noise_deg_s_rthz *= 4.0) > 1.2 * base);
    assert!(bound(|s| s.mag.noise_ut *= 4.0) > 1.2 * base);
    assert!(bound(|s| s.vibration.lateral_m_s2 *= 4.0) > 1.01 * base);
    assert!(bound(|s| s.gyro.bias_walk_deg_s_rts *= 20.0) > 1.2 * base);
}

/// The paper's question in one run, the gyro alone for six minutes: one window removes nearly all of the raw
/// gyro's drift.
#[test]
fn one_window_keeps_inclination_for_six_minutes() {
    let mut drilling = scenario("drilling_45deg").unwrap();
    drilling.earth.latitude_deg = Some(50.0);
    let run = Run::simulate(&drilling, 1).unwrap();
    let models = Contenders::of(&run, 1).unwrap().models;
    let inclination = |index: usize| rms(&Drift::of(&run, &models[index]).unwrap().inclination_deg);
    println!("raw {:.2}, IMOA {:.2}, true {:.2} deg", inclination(0), inclination(IMOA), inclination(TRUE));
    assert_eq!(NAMES[0], "raw");
    assert!(inclination(IMOA) < 0.2 * inclination(0));
    assert!(inclination(IMOA) < 1.0 && inclination(TRUE) < 0.5);
}

#[test]
fn an_unknown_section_is_a_usage_error_that_lists_the_others() {
    let refused = mwd(&["--only", "nonsense"]);
    assert_eq!(refused.status.code(), Some(2));
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(message.starts_with("error: --only nonsense: "), "{message}");
    for name in ["rate_error", "inclination", "paper", "turntable", "hour", "coverage", "swaps"] {
        assert!(message.contains(name), "{message}");
    }
    assert!(refused.stdout.is_empty());
    assert_eq!(mwd(&["--seeds", "0"]).status.code(), Some(2));
}

#[test]
fn a_section_of_the_other_place_says_where_it_runs() {
    let here = mwd(&["--only", "hour", "--only", "cost"]);
    assert_eq!(here.status.code(), Some(2));
    assert!(String::from_utf8(here.stderr).unwrap().starts_with("error: --only cost: needs --target\n"));
    let there = mwd(&["--target", "--only", "hour"]);
    assert_eq!(there.status.code(), Some(2));
    assert!(String::from_utf8(there.stderr).unwrap().starts_with("error: --only hour: runs without --target\n"));
}

#[test]
fn a_folder_of_recordings_that_cannot_be_read_is_named() {
    for section in ["recordings", "benefit", "attitude"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mwd"));
        command.args(["bench", "--only", section]).env("MWD_RECORDINGS", "/nonexistent/recordings");
        let refused = command.output().unwrap();
        assert_eq!(refused.status.code(), Some(2), "{refused:?}");
        let message = String::from_utf8(refused.stderr).unwrap();
        assert!(message.starts_with("error: MWD_RECORDINGS: /nonexistent/recordings: cannot be read"), "{message}");
    }
}

#[test]
fn every_section_runs_and_says_in_json_what_they_print() {
    let directory = TempDir::new().unwrap();
    let file = directory.path().join("bench.json");
    let output = mwd(&["--seeds", "1", "--json", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(output.stderr.is_empty(), "no progress in a pipe");
    let printed = String::from_utf8(output.stdout).unwrap();

    let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(document["schema"], "meerkat-mwd-bench/1");
    let tables = document["tables"].as_array().unwrap();
    let mut sections: Vec<&str> = tables.iter().map(|entry| entry["section"].as_str().unwrap()).collect();
    sections.dedup();
    for name in [
        "rate_error",
        "inclination",
        "paper",
        "coverage",
        "turntable",
        "hour",
        "swaps",
        "effects",
        "recordings",
        "benefit",
    ] {
        assert_eq!(sections.iter().filter(|section| **section == name).count(), 1, "{name}");
    }
    for entry in tables {
        let table = &entry["table"];
        assert!(printed.contains(table["title"].as_str().unwrap()));
        let columns = table["columns"].as_array().unwrap().len();
        for row in table["rows"].as_array().unwrap() {
            let cells = row.as_array().unwrap();
            assert_eq!(cells.len(), columns, "{row}");
            for cell in cells {
                check_cell(cell);
                assert!(printed.contains(cell["text"].as_str().unwrap()));
            }
        }
    }
    // Numbers are there as numbers: raw, in the first table.
    let first = &tables[0]["table"]["rows"][0];
    assert_eq!(first[0]["text"], "raw");
    assert!(first[1]["median"].as_f64().unwrap() > 1.0 && first[1]["worst"].as_f64() >= first[1]["median"].as_f64());

    let again = mwd(&["--seeds", "1", "--only", "rate_error"]);
    assert!(printed.starts_with(&*String::from_utf8(again.stdout).unwrap()), "the same whoever shares the seeds");
}

#[test]
fn a_page_of_measurements_is_what_the_command_in_its_first_line_prints() {
    let directory = TempDir::new().unwrap();
    let folder = directory.path().join("pages");
    let arguments = ["--seeds", "1", "--only", "turntable", "--markdown", folder.to_str().unwrap()];
    let output = mwd(&arguments);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let page = std::fs::read_to_string(folder.join("turntable.md")).unwrap();
    let command = "    cargo mwd bench --only turntable --seeds 1 --markdown docs/measurements\n";
    assert!(page.starts_with(command), "{page}");
    assert!(page.trim_end().ends_with(String::from_utf8(output.stdout).unwrap().trim_end()), "{page}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

/// Checks that a cell has a text, and either one value, or median and worst, or no number.
fn check_cell(cell: &Value) {
    let fields: Vec<&str> = cell.as_object().unwrap().keys().map(String::as_str).collect();
    assert!(cell["text"].is_string());
    assert!(fields.iter().all(|name| ["text", "value", "median", "worst"].contains(name)), "{cell}");

    assert!(!(fields.contains(&"value") && fields.contains(&"median")), "{cell}");
}

#[test]
fn the_json_goes_nowhere_where_it_cannot_be_written() {
    let refused = mwd(&["--seeds", "1", "--only", "turntable", "--json", "/nonexistent/bench.json"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8(refused.stderr).unwrap().contains("/nonexistent/bench.json"));
}

/// On the standard output it is alone, and the tables are on the standard error.
#[test]
fn the_json_may_go_to_the_standard_output() {
    let output = mwd(&["--seeds", "1", "--only", "turntable", "--json", "-"]);
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["tables"][0]["section"], "turntable");
    assert!(output.status.success() && !output.stderr.is_empty(), "{output:?}");
}

/// If the emulator is missing and may not be installed, the exit status and the message say so.
#[test]
fn without_an_emulator_the_cost_on_the_chip_is_not_made_up() {
    let nothing = TempDir::new().unwrap();
    let refused = Command::new(env!("CARGO_BIN_EXE_mwd"))
        .args(["bench", "--target"])
        .env("MWD_NO_INSTALL", "1")
        .env("PATH", nothing.path())
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(3), "{refused:?}");
    assert!(refused.stdout.is_empty() && !refused.stderr.is_empty());
}
