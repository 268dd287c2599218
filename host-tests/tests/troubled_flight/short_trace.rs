//! Traces that end before a window does.

use meerkat_mwd::identification::Refusal;
use mwd::{configuration::freeze_at_us, window_note::why_no_window};

use crate::rig::{Run, refusal, run};

fn held_out(mut run: Run, fraction: f64) -> Run {
    run.config.freeze_at_us = Some(freeze_at_us(&run.trace, fraction));
    run
}

#[test]
fn every_sample_has_an_attitude_and_a_note_says_why_there_is_no_window() {
    let run = run(30.0, 1);
    let flight = run.fly(&run.trace.samples);
    assert!(flight.reports.is_empty());
    assert!(flight.outputs.iter().all(|o| o.attitude.is_some()));
    let why = why_no_window(&run.trace, &run.config, &flight).unwrap();
    assert!(why.contains("the trace lasts 30.0 s; a window takes 50.0 s and its result 5.0 s more"), "{why}");
}

#[test]
fn a_short_training_part_is_refused_with_its_length() {
    // Half of 44 s, less 5 s of latency: 17 s.
    let run = held_out(run(44.0, 1), 0.5);
    let flight = run.fly(&run.trace.samples);
    assert_eq!(flight.reports.len(), 1);
    let Some(Refusal::WindowTooShort { length_s, needed_s, cut_by_gap }) = refusal(&flight.reports[0]) else {
        panic!("{:?}", flight.reports[0])
    };
    assert!((length_s - 17.0).abs() < 0.02 && needed_s == 20.0 && !cut_by_gap);
    assert_eq!(why_no_window(&run.trace, &run.config, &flight), None, "the window says it");
    assert_eq!(flight.reports[0].flown.p, run.config.gyro.p);
    assert_eq!(flight.reports[0].rest_s, 10.0);
    run.never_worse_than_bias_only(&flight);
}

#[test]
fn a_training_part_shorter_than_the_latency_gets_the_note() {
    let run = held_out(run(8.0, 1), 0.5);
    let flight = run.fly(&run.trace.samples);
    assert!(flight.outputs.iter().all(|o| o.attitude.is_some()));
    let why = why_no_window(&run.trace, &run.config, &flight);
    let said = why.is_some_and(|why| why.contains("before the hold-out lasts 4.0 s"));
    assert!(said || refusal(&flight.reports[0]).is_some());
}

#[test]
fn one_sample_and_two_are_flown_as_well() {
    let run = run(1.0, 1);
    for count in [0, 1, 2] {
        let flight = run.fly(&run.trace.samples[..count]);
        assert_eq!(flight.outputs.len(), count);
        assert!(flight.outputs.iter().all(|o| o.attitude.is_some()) && flight.reports.is_empty());
    }
}
