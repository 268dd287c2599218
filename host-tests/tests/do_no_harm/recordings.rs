//! Recordings of real sensors, as they are and with a known error multiplied into the gyro. The whole ones
//! are not in this repository: `MWD_RECORDINGS` names their folder.

use crate::played::{Played, play};
use meerkat_mwd::config::OptimizerKind;
use std::path::PathBuf;
use testbed::{
    simulate::known_error,
    trace::{
        Trace,
        recordings::{FOLDER, bundled, given, name},
    },
};

/// Draws of the known error for each recording.
const DRAWS: u64 = 2;

fn traces(paths: &[PathBuf]) -> Vec<(String, Trace)> {
    paths.iter().map(|path| (name(path), Trace::read(path).unwrap())).collect()
}

fn whole() -> Vec<(String, Trace)> {
    let paths = given().unwrap();
    assert!(!paths.is_empty(), "{FOLDER} names a folder of recordings");
    traces(&paths)
}

/// Checks that what flies turns as the bias alone does, or better.
fn as_they_are(traces: &[(String, Trace)]) {
    for (name, trace) in traces {
        for hold_out in [0.3, 0.5, 0.7] {
            let Some(played) = play(trace, hold_out, OptimizerKind::Imoa) else { continue };
            println!("{name} {hold_out}: accepted {}, ratio {:.3}", played.accepted(), played.ratio());
            assert!(!played.harmful(), "{name} {hold_out}: {:?}", played.scores);
        }
    }
}

/// Remaining error over that of the bias alone, in increasing order.
fn with_known_errors(traces: &[(String, Trace)]) -> Vec<f64> {
    let mut ratios = Vec::new();
    for (index, (name, trace)) in traces.iter().enumerate() {
        for draw in 0..DRAWS {
            let seed = 100 + DRAWS * index as u64 + draw;
            let mut wrong = trace.clone();
            known_error::apply(&mut wrong, &known_error::draw(seed));
            let Some(played) = play(&wrong, 0.5, OptimizerKind::Imoa) else { continue };
            println!("{name} {seed}: {}", line(&played));
            assert!(!played.harmful(), "{name} {seed}: {:?}", played.scores);
            ratios.push(played.ratio());
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!("ratios {ratios:.3?}");
    ratios
}

fn line(played: &Played) -> String {
    let last = played.reports.last().map(|report| report.decision);
    let (bias, flown) = (played.scores.bias_only.unwrap(), played.scores.with_effects.unwrap());
    format!("accepted {}, bias only {bias:.2}, flown {flown:.2} deg; last {last:?}", played.accepted())
}

#[test]
fn what_flies_on_the_bundled_recordings_is_no_worse_than_the_bias_alone() {
    as_they_are(&traces(&bundled().unwrap()));
}

#[test]
fn no_known_error_makes_the_bundled_recordings_worse() {
    with_known_errors(&traces(&bundled().unwrap()));
}

#[test]
#[ignore = "needs recordings that are not in this repository"]
fn what_flies_on_whole_recordings_is_no_worse_than_the_bias_alone() {
    as_they_are(&whole());
}

#[test]
#[ignore = "needs recordings that are not in this repository"]
fn known_errors_of_whole_recordings_are_found_and_taken_out() {
    let ratios = with_known_errors(&whole());
    assert!(ratios[ratios.len() / 2] < 0.2, "{ratios:?}");
}
