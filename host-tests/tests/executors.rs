//! The library under an executor, on the emulated chip.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "rig/emulator.rs"]
mod emulator;

use mwd::target::{deadline, machine::build_program};
use std::{process::Command, time::Duration};

/// The example takes 800 samples of a tool at rest at 30 deg in an interrupt, and loses none: else it says so and fails.
#[test]
fn rtic_flies_every_sample_that_an_interrupt_takes() {
    let Some(toolchain) = emulator::toolchain() else { return };
    let image = build_program(&toolchain, "rtic-probe").unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none"]);
    // Deterministic time: ticks of a busy machine would else be lost.
    qemu.args(["-icount", "shift=3,sleep=off", "-semihosting-config", "enable=on,target=native", "-kernel"]);
    let printed = deadline::run(qemu.arg(image), Duration::from_secs(60)).unwrap_or_else(|error| panic!("{error}"));
    let numbers: Vec<i32> = printed.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let [samples, inclination_mdeg, azimuth_mdeg] = numbers.try_into().unwrap();
    assert_eq!(samples, 800);
    assert!((inclination_mdeg - 30_000).abs() < 50, "{inclination_mdeg}");
    assert!((0..360_000).contains(&azimuth_mdeg), "{azimuth_mdeg}");
}
