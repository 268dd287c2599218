//! On a line that is too slow, attitudes are dropped and counted; results are not.

use super::{
    drilling::{LIMIT, drilling, everything},
    received::Received,
};
use crate::rig::emulator::toolchain;
use meerkat_mwd::telemetry::StreamConfig;
use mwd::target::real_time::RealTime;

#[test]
fn a_slow_line_costs_attitudes_and_no_result() {
    let Some(toolchain) = toolchain() else { return };
    let (config, samples) = drilling(70.0, 3);
    // 600 bytes a second: some 8 of 200 attitudes.
    let stream = StreamConfig { bytes_per_s: 600, ..everything() };
    let landed = RealTime { config, stream, ..RealTime::default() }.run(&toolchain, &samples, LIMIT).unwrap();
    let received = Received::of(&landed.serial);
    assert!(received.is_whole(), "{:?}", received.link);
    assert!(landed.serial.len() as f64 <= 600.0 * 70.0 * 1.05, "{} bytes", landed.serial.len());
    let (given_up, sent) = (landed.count("attitude_dropped").unwrap(), received.outputs.len() as u64);
    let outputs = samples.len() as u64;
    println!("{outputs} attitudes: {sent} sent, {given_up} given up; {} results", received.identifications.len());
    assert!(sent > 100 && (outputs - sent - given_up) < 10, "{outputs} = {sent} + {given_up}");
    assert_eq!(landed.count("windows"), Some(received.identifications.len() as u64));
    assert_eq!(landed.count("diagnoses"), Some(received.diagnoses.len() as u64));
    assert_eq!(landed.count("results_lost"), Some(0));
}
