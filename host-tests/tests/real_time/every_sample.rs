//! Every sample is processed once and in time, while identification and diagnosis run.

use super::drilling::{drilling, toolchain};
use mwd::emulate::real_time::{Landed, RealTime};
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(1_800);

fn fly(duration_s: f64) -> Option<(u64, Landed)> {
    let toolchain = toolchain()?;
    let (config, samples) = drilling(duration_s, 1);
    let run = RealTime { config, ..RealTime::default() };
    let landed = run.run(&toolchain, &samples, LIMIT).unwrap();
    println!("{duration_s} s at 200 Hz: {:#?}", landed.values);
    assert_eq!(landed, run.run(&toolchain, &samples, LIMIT).unwrap(), "the same run is the same");
    Some((samples.len() as u64, landed))
}

fn assert_every_sample_once(samples: u64, landed: &Landed) {
    for name in ["acquired", "processed", "samples"] {
        assert_eq!(landed.count(name), Some(samples), "{name}");
    }
    for name in ["queue_full", "missed_ticks", "sequence_breaks", "out_of_order", "gaps", "overruns", "diagnosis_overruns"] {
        assert_eq!(landed.count(name), Some(0), "{name}");
    }
}

#[test]
fn three_minutes_with_identification_and_diagnosis_lose_nothing() {
    let Some((samples, landed)) = fly(180.0) else { return };
    assert_every_sample_once(samples, &landed);
    assert!(landed.count("windows") > Some(0) && landed.count("diagnoses") > Some(0));
}

#[test]
#[ignore = "an hour of virtual time, twice: some minutes"]
fn an_hour_with_identification_and_diagnosis_loses_nothing() {
    let Some((samples, landed)) = fly(3_600.0) else { return };
    assert_every_sample_once(samples, &landed);
}
