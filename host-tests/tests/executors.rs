//! The library under executors, on the emulated chip and on this machine.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "rig/emulator.rs"]
mod emulator;

use mwd::target::{deadline, machine::build_program, toolchain::workspace};
use std::{process::Command, time::Duration};

/// Runs an example, which takes 800 samples of a tool at rest at 30 deg and loses none: else it says so and fails.
/// Returns inclination and azimuth, thousandths of a degree.
fn flown(command: &mut Command, limit: Duration) -> [i32; 2] {
    let printed = deadline::run(command, limit).unwrap_or_else(|error| panic!("{error}"));
    println!("{}", printed.trim());
    let numbers: Vec<i32> = printed.split_whitespace().map(|number| number.parse().unwrap()).collect();
    let [samples, inclination_mdeg, azimuth_mdeg] = numbers.try_into().unwrap();
    assert_eq!(samples, 800);
    [inclination_mdeg, azimuth_mdeg]
}

fn on_the_chip(package: &str) -> Option<[i32; 2]> {
    let toolchain = emulator::toolchain()?;
    let image = build_program(&toolchain, package).unwrap();
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.args(["-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none"]);
    // Deterministic time: ticks of a busy machine would else be lost.
    qemu.args(["-icount", "shift=3,sleep=off", "-semihosting-config", "enable=on,target=native", "-kernel"]);
    Some(flown(qemu.arg(image), Duration::from_secs(60)))
}

#[test]
fn rtic_flies_every_sample_that_an_interrupt_takes() {
    let Some([inclination_mdeg, azimuth_mdeg]) = on_the_chip("rtic-probe") else { return };
    assert!((inclination_mdeg - 30_000).abs() < 50, "{inclination_mdeg}");
    assert!((0..360_000).contains(&azimuth_mdeg), "{azimuth_mdeg}");
}

/// Asynchronous drivers on register models; the same task reads on a chip and here, where the clock does not wait.
#[test]
fn embassy_flies_what_a_task_reads_over_asynchronous_buses() {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(workspace()).args(["run", "--quiet", "-p", "embassy-probe"]);
    let here = flown(&mut cargo, Duration::from_secs(900));
    assert!((here[0] - 30_000).abs() < 50 && (0..360_000).contains(&here[1]), "{here:?}");
    if let Some(there) = on_the_chip("embassy-probe") {
        assert_eq!(there, here, "the sensors' readings are the same");
    }
}
