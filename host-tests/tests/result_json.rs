//! The windows and the final parameters of the JSON result.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod rig;

use meerkat_mwd::{
    Config,
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, Refusal, WindowReport},
};
use mwd::{
    diagnosis::diagnosed,
    layout::Layout,
    report::{json::result_json, summary::print_summary},
};
use serde_json::Value;
use testbed::{
    flight::{Flight, configuration::of_trace, fly},
    simulate::{Effects, Scenario, simulate},
    trace::Trace,
};

fn model(scale: f32, bias: f32) -> GyroModel {
    GyroModel { p: [[scale, 0.1, 0.2], [0.3, scale, 0.4], [0.5, 0.6, scale]], b_rad_s: [bias, 0.0, 0.0] }
}

fn report(start_s: u64, decision: Decision, fitted: GyroModel, flown: GyroModel) -> WindowReport {
    WindowReport {
        t_start_us: start_s * 1_000_000,
        t_end_us: (start_s + 50) * 1_000_000,
        t_effect_us: Some((start_s + 55) * 1_000_000),
        optimizer: OptimizerKind::Lm,
        evaluations: 123,
        cost_before: Some(0.1),
        cost_after: Some(f32::NAN),
        fitted,
        flown,
        sigma: [start_s as f32; 12],
        observable: [true; 12],
        rank: 12,
        rest_s: 1.5,
        motion_s: 40.0,
        directions_decided: 7,
        innovation_nis: 1.125,
        deg_per_turn: 0.5,
        widths: [1.0, 0.25, 3.0, 0.5, 2.0],
        ..rig::report::report(decision)
    }
}

/// A number of single precision, whichever way JSON keeps it.
fn single(value: &Value) -> f32 {
    value.as_f64().unwrap() as f32
}

fn summary(reports: Vec<WindowReport>) -> String {
    let flight = Flight { reports, ..Flight::default() };
    let (trace, config) = (Trace::default(), Config::default());
    let mut text = Vec::new();
    print_summary(&mut text, Layout::Table, &trace, &config, &flight, &diagnosed(&trace, &config, &flight), None)
        .unwrap();
    String::from_utf8(text).unwrap()
}

fn result(reports: Vec<WindowReport>) -> Value {
    let flight = Flight { reports, ..Flight::default() };
    let (trace, config) = (Trace::default(), Config::default());
    let diagnosed = diagnosed(&trace, &config, &flight);
    serde_json::to_value(result_json(&trace, &config, &flight, &diagnosed, None)).unwrap()
}

#[test]
fn an_accepted_window_gives_the_final_p_its_uncertainty_and_a_later_refusal_only_moves_the_bias() {
    let refusal = Decision::Refused(Refusal::Diverged { nis: 3.5 });
    let result = result(vec![
        report(25, Decision::Accepted, model(1.1, 0.01), model(1.1, 0.01)),
        report(50, refusal, model(1.3, 0.03), model(1.1, 0.02)),
    ]);
    let windows = &result["identification"]["windows"];
    assert_eq!((&windows[0]["accepted"], &windows[0]["reason"]), (&true.into(), &Value::Null));
    assert_eq!(windows[1]["accepted"], false);
    assert!(windows[1]["reason"].as_str().unwrap().contains("3.5 times"));
    assert_eq!((&windows[0]["t_start_s"], &windows[0]["t_end_s"]), (&25.0.into(), &75.0.into()));
    assert_eq!((&windows[0]["optimizer"], &windows[0]["evaluations"]), (&"lm".into(), &123.into()));
    assert_eq!(windows[0]["cost_after"], Value::Null);
    assert_eq!(single(&windows[1]["P"][0]), 1.3);
    assert_eq!(single(&windows[1]["P"][5]), 0.4);
    let last = &result["identification"]["final"];
    assert_eq!(single(&last["P"][0]), 1.1);
    assert_eq!(single(&last["b_rad_s"][0]), 0.02);
    assert_eq!((&last["sigma"][0], &last["rank"]), (&25.0.into(), &12.into()));
}

#[test]
fn when_nothing_was_accepted_the_final_uncertainty_is_the_prior() {
    let flown = GyroModel { b_rad_s: [0.02, 0.0, 0.0], ..GyroModel::IDENTITY };
    let result = result(vec![report(
        0,
        Decision::Refused(Refusal::NotEnoughMotion { motion_s: 3.0, needed_s: 10.0 }),
        model(1.3, 0.03),
        flown,
    )]);
    let last = &result["identification"]["final"];
    assert_eq!((&last["P"][0], &last["P"][1]), (&1.0.into(), &0.0.into()));
    assert_eq!(single(&last["b_rad_s"][0]), 0.02);
    let sigma: Vec<f32> = last["sigma"].as_array().unwrap().iter().map(single).collect();
    let (diagonal, off, bias) = (0.06, 0.03, 0.021);
    assert_eq!(sigma, [diagonal, off, off, off, diagonal, off, off, off, diagonal, bias, bias, bias]);
    assert_eq!(last["rank"], 0);
}

/// A number that does not exist is null.
#[test]
fn a_window_says_what_it_rests_on_and_an_overrun_nothing() {
    let flown = model(1.1, 0.01);
    let mut overrun = report(50, Decision::Refused(Refusal::Overrun), flown, flown);
    overrun.t_effect_us = None;
    let result = result(vec![report(25, Decision::Accepted, flown, flown), overrun]);
    let [window, late] = [0, 1].map(|i: usize| &result["identification"]["windows"][i]);
    assert_eq!((&window["motion_s"], &window["directions_decided"]), (&40.0.into(), &7.into()));
    assert_eq!((&window["innovation_nis"], &window["deg_per_turn"]), (&1.125.into(), &0.5.into()));
    let widths = serde_json::json!({ "magnetometer_matrix": 1.0, "magnetometer_misalignment": 0.5, "hard_iron": 0.25, "accelerometer": 3.0, "accelerometer_bias": 2.0 });
    assert_eq!(window["widths"], widths);
    for key in ["motion_s", "directions_decided", "innovation_nis", "widths"] {
        assert_eq!(late[key], Value::Null, "{key}");
    }
}

#[test]
fn the_summary_says_which_uncertainties_are_only_the_priors_and_which_motion_flew() {
    let refused = Decision::Refused(Refusal::NotEnoughMotion { motion_s: 3.0, needed_s: 10.0 });
    let mut reports = vec![report(25, refused, model(1.3, 0.03), GyroModel::IDENTITY)];
    let text = summary(reports.clone());
    assert!(text.contains("+- 1.2032   deg/s (+- prior); 0 of 12"), "{text}");
    assert!(text.contains("3.0 s of motion"), "{text}");
    reports.push(report(100, Decision::Accepted, model(1.2, 0.01), model(1.2, 0.01)));
    let text = summary(reports);
    assert!(!text.contains("prior"), "{text}");
    // The library's own default; a trace without a key and with the sensor's axes flies by hand.
    assert!(text.contains("motion: drill_string (configuration)"), "{text}");
}

#[test]
fn the_summary_of_a_long_flight_fits_a_screen() {
    let reports = (0..200).map(|i| report(25 * i, Decision::Accepted, model(1.0, 0.0), model(1.0, 0.0))).collect();
    let text = summary(reports);
    assert!(text.contains("200: 200 accepted, 0 refused"));
    assert!(text.lines().count() <= 40, "{text}");
}

/// An effect says when it was found and since when it is taken out, by how much it is likelier than not, and
/// nothing of p-values.
#[test]
fn an_effect_has_its_times_and_its_evidence() {
    let effects = Effects { mag_lag_ms: 11.0, ..Effects::default() };
    let trace = simulate(&Scenario { duration_s: 120.0, effects, ..Scenario::default() }, 5).0;
    let config = of_trace(&trace);
    let flight = fly(&config, &trace.samples, |_| {}).unwrap();
    let diagnosed = diagnosed(&trace, &config, &flight);
    let result = serde_json::to_value(result_json(&trace, &config, &flight, &diagnosed, None)).unwrap();
    let all = result["diagnosis"]["effects"].as_array().unwrap();
    let [effect] = all.as_slice() else { panic!("{all:?}") };
    assert_eq!(effect["name"], "mag_lag");
    let [found_s, taken_out_s, evidence] =
        ["found_s", "taken_out_s", "evidence"].map(|key| effect[key].as_f64().unwrap());
    // Drilling begins after 10 s; what flies is updated every 5 s, and a result takes effect a second later.
    assert!((10.0..50.0).contains(&found_s) && taken_out_s > found_s && taken_out_s < found_s + 2.0, "{effect}");
    assert!(evidence > 5.0 && effect["taken_out"] == true, "{effect}");
    let keys: Vec<&String> = effect.as_object().unwrap().keys().collect();
    assert!(keys.iter().all(|key| !key.contains("p_value") && !key.contains("believed")), "{keys:?}");
}
