//! Every sample is processed once and in time while identification and diagnosis run, and gives what it gives
//! on the host.

use super::{
    drilling::{LIMIT, drilling, everything, missing_of_the_host},
    received::Received,
};
use crate::rig::emulator::toolchain;
use meerkat_mwd::Sample;
use mwd::target::{
    image,
    real_time::{Landed, RealTime},
};

/// Flies, and checks what holds of every run.
fn fly(duration_s: f64) -> Option<(Landed, Received)> {
    let toolchain = toolchain()?;
    let (config, samples) = drilling(duration_s, 1);
    let run = RealTime { config, stream: everything(), recording: true, ..RealTime::default() };
    let landed = run.run(&toolchain, &samples, LIMIT).unwrap();
    println!("{duration_s} s at 200 Hz: {:#?}", landed.values);

    for name in ["acquired", "processed", "samples"] {
        assert_eq!(landed.count(name), Some(samples.len() as u64), "{name}");
    }
    for name in ["queue_full", "missed_ticks", "sequence_breaks", "out_of_order", "gaps", "overruns"] {
        assert_eq!(landed.count(name), Some(0), "{name}");
    }
    for name in ["reports_lost", "diagnoses_lost", "results_lost", "samples_dropped"] {
        assert_eq!(landed.count(name), Some(0), "{name}");
    }
    let received = Received::of(&landed.serial);
    assert!(received.is_whole(), "{:?}", received.link);
    // Samples still in the queue when the sensors' file ends were not sent.
    let missing = missing_of_the_host(&config, &run.through_sensors(&samples), &received.outputs);
    assert!(missing <= landed.count("attitude_dropped").unwrap() + 2, "{missing} outputs are missing");
    assert_eq!(landed.count("windows"), Some(received.identifications.len() as u64));
    assert_eq!(landed.count("diagnoses"), Some(received.diagnoses.len() as u64));
    Some((landed, received))
}

/// Asserts that the recording over the line replays to the same attitude.
fn assert_recording_replays(received: &Received) {
    let [boot] = received.boots[..] else { panic!("{} boots", received.boots.len()) };
    let numbers: Vec<u32> = received.samples.iter().map(|sample| sample.number).collect();
    assert!(numbers.iter().copied().eq(0..numbers.len() as u32), "a sample is missing");
    let samples: Vec<Sample> = received.samples.iter().map(|sample| sample.sample).collect();
    missing_of_the_host(&boot.config, &samples, &received.outputs);
}

/// Stack for the sensors' interrupt, bytes: 192 of its handler, 1,208 of the register models' service, up to 412 of
/// what that calls, 104 of the exception's own frame.
const INTERRUPT_BYTES: u32 = 2_048;

/// In the second half the loop itself goes no deeper: what the high-water mark still grows by is the
/// interrupt, which lies on whatever it comes upon, sooner or later on the deepest call.
fn assert_memory(received: &Received) {
    let marks: Vec<u32> = received.healths.iter().map(|health| health.stack_used_bytes).collect();
    println!("stack after each 5 s: {marks:?} of {}", received.healths[0].stack_size_bytes);
    let (last, before) = (marks[marks.len() - 1], marks[marks.len() / 2]);
    assert!(last - before < INTERRUPT_BYTES, "the stack still grows in the second half: {before} to {last}");
    assert!(u64::from(last) <= image::STACK_LIMIT_BYTES, "{last} bytes of stack");
}

#[test]
fn the_same_run_is_the_same() {
    let Some(toolchain) = toolchain() else { return };
    let (config, samples) = drilling(30.0, 1);
    let run = RealTime { config, stream: everything(), recording: true, ..RealTime::default() };
    let [first, second] = [(); 2].map(|()| run.run(&toolchain, &samples, LIMIT).unwrap());
    assert_eq!(first, second);
}

#[test]
fn minutes_with_identification_and_diagnosis_lose_nothing_and_replay() {
    let Some((landed, received)) = fly(180.0) else { return };
    assert!(landed.count("windows") > Some(1) && landed.count("diagnoses") > Some(0));
    assert_recording_replays(&received);
    assert_memory(&received);
    assert!(landed.count("delay_worst_us") <= Some(image::DELAY_LIMIT_US), "{:?}", landed.values);
}

#[test]
#[ignore = "an hour of virtual time: some minutes"]
fn an_hour_with_identification_and_diagnosis_loses_nothing() {
    let Some((landed, received)) = fly(3_600.0) else { return };
    assert!(landed.count("windows") > Some(50) && landed.count("diagnoses") > Some(50));
    assert_recording_replays(&received);
    assert_memory(&received);
    assert!(landed.count("delay_worst_us") <= Some(image::DELAY_LIMIT_US), "{:?}", landed.values);
}
