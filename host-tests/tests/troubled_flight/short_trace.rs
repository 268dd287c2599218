//! Traces that end before a window does.

use meerkat_mwd::identification::Refusal;
use mwd::report::window_note::why_no_window;
use testbed::flight::{Flight, configuration::freeze_at_us};

use crate::rig::run::{Run, refusal, run};

/// Flies a run with its last `fraction` held out.
fn held_out(run: &Run, fraction: f64) -> Flight {
    run.fly_frozen(Some(freeze_at_us(&run.trace, fraction)), &run.trace.samples)
}

#[test]
fn every_sample_has_an_attitude_and_a_note_says_why_there_is_no_window() {
    let run = run(30.0, 1);
    let flight = run.fly(&run.trace.samples);
    assert!(flight.reports.is_empty());
    assert!(flight.outputs.iter().all(|o| o.attitude.is_some()));
    let why = why_no_window(&run.trace, &run.config, &flight).unwrap();
    assert!(why.contains("the trace lasts 30.0 s; a window takes 50.0 s and its result 1.0 s more"), "{why}");
}

#[test]
fn a_short_training_part_is_refused_with_its_motion() {
    // Half of 30 s, less 1 s of latency and 10 s of rest: 4 s, which is too little even where the data exclude the
    // factory's P.
    let run = run(30.0, 1);
    let flight = held_out(&run, 0.5);
    assert_eq!(flight.reports.len(), 1);
    let Some(Refusal::NotEnoughMotion { motion_s, needed_s }) = refusal(&flight.reports[0]) else {
        panic!("{:?}", flight.reports[0])
    };
    assert!((motion_s - 4.0).abs() < 1.0 && motion_s < needed_s, "{motion_s} of {needed_s}");
    assert_eq!(flight.reports[0].motion_s, motion_s);
    assert_eq!((flight.reports[0].t_start_us, flight.reports[0].t_end_us), (0, 14_000_000));
    assert_eq!(why_no_window(&run.trace, &run.config, &flight), None, "the window says it");
    assert_eq!(flight.reports[0].flown.p, run.config.gyro.p);
    // In whole seconds; the first two half seconds have to be compared before they are rest.
    assert!((flight.reports[0].rest_s - 10.0).abs() <= 2.0, "{:?}", flight.reports[0]);
    run.never_worse_than_bias_only(&flight);
}

#[test]
fn a_training_part_shorter_than_the_latency_gets_the_note() {
    let run = run(8.0, 1);
    let flight = held_out(&run, 0.9);
    assert!(flight.outputs.iter().all(|o| o.attitude.is_some()) && flight.reports.is_empty());
    let why = why_no_window(&run.trace, &run.config, &flight).unwrap();
    assert!(why.contains("before the hold-out lasts 0.8 s; the result of a window takes 1.0 s"), "{why}");
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
