//! Log of the probe, as the tools on a board decode it.

use super::drilling::{LIMIT, drilling, everything};
use crate::rig::emulator::toolchain;
use defmt_decoder::{DecodeError, Table};
use mwd::target::{
    firmware::{Board, build_firmware},
    real_time::{RealTime, Stage},
};
use std::fs;

/// The messages of a log, whose strings are in the image that wrote it.
fn decoded(elf: &[u8], log: &[u8]) -> Vec<String> {
    let table = Table::parse(elf).unwrap().unwrap();
    let mut decoder = table.new_stream_decoder();
    decoder.received(log);
    let mut messages = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => messages.push(frame.display_message().to_string()),
            Err(DecodeError::UnexpectedEof) => return messages,
            Err(DecodeError::Malformed) => panic!("after {messages:#?}"),
        }
    }
}

#[test]
fn starts_windows_and_diagnoses_are_logged() {
    let Some(toolchain) = toolchain() else { return };
    let firmware = build_firmware(&toolchain, Board::Emulated).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let (mut config, samples) = drilling(70.0, 1);
    config.identification.window_s = 25.0;
    let hang = Some((Stage::Telemetry, 65 * 200));
    let run = RealTime { config, stream: everything(), hang, ..RealTime::default() };
    run.prepare_in(directory.path(), &firmware, &samples).unwrap();
    let landed = run.run_in(directory.path(), &toolchain, LIMIT).unwrap();
    let messages = decoded(&firmware.elf, &fs::read(directory.path().join("log.bin")).unwrap());
    println!("{messages:#?}");
    let with = |text: &str| messages.iter().filter(|message| message.contains(text)).count();
    assert!(messages[0].starts_with("PowerOn from sample 0, stored model None"));
    assert_eq!((with("PowerOn"), with("Watchdog from sample 0")), (1, 1));
    // The windows of the run that the hang ended are not counted in what was printed.
    assert_eq!((landed.count("windows"), with("window to")), (Some(0), 2));
    assert!(with("TooLittleMotion") + with("Accepted") >= 2, "decisions have their reasons");
}
