//! A main loop that polls too little, too much, or never.

use meerkat_mwd::{Config, Probe, identification::Refusal};
use testbed::{
    flight::{Flight, configuration::of_trace},
    trace::{Trace, recordings::bundled},
};

use crate::rig::run::{Run, refusal, run as flown, sound};

/// A run in which only windows are identified: what their work is sliced into is counted here.
fn run(duration_s: f64, seed: u64) -> Run {
    let run = flown(duration_s, seed);
    Run { config: Config { effects: false, ..run.config }, ..run }
}

/// Units of work that a probe at 100 Hz asks for.
const BUDGET: u32 = 1_600;

/// Flies with `budget(index)` units of work after each sample; `None`: not polled.
fn polled(run: &Run, budget: impl Fn(usize) -> Option<u32>) -> Flight {
    let mut probe = Box::new(Probe::new());
    probe.configure(&run.config).unwrap();
    let mut flight = Flight::default();
    for (index, sample) in run.trace.samples.iter().enumerate() {
        flight.outputs.extend(probe.push(sample));
        flight.reports.extend(budget(index).and_then(|units| probe.poll(units)));
        flight.diagnoses.extend(probe.take_diagnosis());
    }
    while let Some(report) = probe.poll(0) {
        flight.reports.push(report);
    }
    flight.counters = probe.counters();
    sound(&flight, run.trace.samples.len());
    flight
}

#[test]
fn how_the_work_is_sliced_changes_nothing_while_it_is_in_time() {
    let run = run(110.0, 3);
    let expected = polled(&run, |_| Some(BUDGET));
    assert_eq!(expected.counters.overruns, 0);
    assert_eq!(expected, polled(&run, |_| Some(800)), "a few pieces after each sample");
    assert_eq!(expected, polled(&run, |_| Some(u32::MAX)), "all at once");
    // Not after the sample at which a result takes effect, its report comes later; what flies does not
    // change.
    for every in [7, 50, 90] {
        let now_and_then = polled(&run, |index| (index % every == 0).then_some(u32::MAX));
        assert_eq!(expected, now_and_then, "every {every} samples");
    }
}

#[test]
fn a_search_that_is_not_done_in_time_is_an_overrun_and_never_half_a_result() {
    let run = run(110.0, 3);
    let expected = polled(&run, |_| Some(BUDGET));
    let (mut in_time, mut late) = (0, 0);
    for every in [1, 2, 3, 5, 10, 50, 90, 100, 150, 190, 300, 499, 600] {
        for budget in [1, 100, 300, 20_000, u32::MAX] {
            let flight = polled(&run, |index| (index % every == 1).then_some(budget));
            // Two reports wait; one more is lost and counted.
            assert_eq!(flight.reports.len() + flight.counters.reports_lost as usize, expected.reports.len());
            let overruns = flight.counters.overruns;
            for report in &flight.reports {
                let is_late = refusal(report) == Some(Refusal::Overrun);
                assert_eq!(report.t_effect_us.is_none(), is_late, "{report:?}");
                assert!(overruns > 0 || !is_late);
            }
            run.never_worse_than_bias_only(&flight);
            if overruns > 0 {
                late += 1;
            } else {
                assert_eq!(flight.reports, expected.reports, "every {every}, budget {budget}");
                assert_eq!(flight.outputs, expected.outputs, "every {every}, budget {budget}");
                in_time += 1;
            }
        }
    }
    println!("{in_time} ways of polling in time, {late} late");
    assert!(in_time > 10 && late > 10);
}

#[test]
fn never_polled_the_old_model_stays_and_what_is_lost_is_counted() {
    let run = run(260.0, 3);
    let flight = polled(&run, |_| None);
    // Windows close at 50, 75, ..., 250 s, and updates at 5, 10, ..., 255 s: the result of the last is due at
    // 256 s.
    let (windows, updates) = (9, 51);
    assert_eq!(flight.counters.overruns, updates);
    assert_eq!(flight.reports.len() as u32 + flight.counters.reports_lost, windows);
    assert!(flight.counters.reports_lost > 0 && !flight.reports.is_empty());
    assert!(flight.reports.iter().all(|r| refusal(r) == Some(Refusal::Overrun)));
    for (output, sample) in flight.outputs.iter().zip(&run.trace.samples) {
        assert_eq!(output.rate_rad_s, sample.gyro_rad_s, "the factory's model is the identity");
    }
}

#[test]
fn a_diagnosis_is_the_same_however_its_work_is_sliced_and_late_it_is_counted() {
    let run = flown(110.0, 3);
    let expected = polled(&run, |_| Some(BUDGET));
    assert_eq!(expected.counters.overruns, 0);
    assert!(!expected.diagnoses.is_empty());
    for every in [1, 7, 50] {
        assert_eq!(expected, polled(&run, |index| (index % every == 0).then_some(u32::MAX)), "every {every} samples");
    }
    let late = polled(&run, |_| Some(1));
    assert!(late.counters.overruns > 0);
    assert!(late.diagnoses.len() < expected.diagnoses.len());
}

/// Half of a chip's time is enough from 64 MHz on: what flies is what flies on one of 168 MHz.
#[test]
fn at_64_mhz_nothing_is_late_and_nothing_is_lost() {
    for path in bundled().unwrap() {
        let trace = Trace::read(&path).unwrap();
        let config = of_trace(&trace);
        let [fast, slow] = [168_000_000, 64_000_000].map(|clock_hz| {
            let mut probe = Box::new(Probe::new());
            probe.configure(&config).unwrap();
            let budget = probe.poll_budget_at(clock_hz);
            let mut flown = Vec::new();
            for sample in &trace.samples {
                flown.extend(probe.push(sample));
                // When a report is there is the budget's to say; what flies is not.
                probe.poll(budget);
            }
            let counters = probe.counters();
            assert_eq!((counters.overruns, counters.increments_lost), (0, 0), "{}, {clock_hz} Hz", path.display());
            flown
        });
        assert!(fast == slow, "{}", path.display());
    }
}
