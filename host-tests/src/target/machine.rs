//! The emulated chip: its clock, and programs built for it and run on it.

use std::{path::PathBuf, process::Command, time::Duration};

use super::{deadline, error::EmulateError, toolchain::Toolchain};

/// Time allowed for a build; a cold one takes some ten seconds.
pub(super) const BUILD: Duration = Duration::from_secs(900);
/// Time allowed for a run, and for each sample of it: far more than any identification takes.
pub(super) const RUN: Duration = Duration::from_secs(120);
pub(super) const RUN_PER_SAMPLE: Duration = Duration::from_millis(10);
/// 64 ns for every instruction: time then depends on the instructions alone, and 168 MHz ticks resolve single
/// ones.
const INSTRUCTION_CLOCK: &str = "shift=6,sleep=off";

/// The emulator with an instruction clock; the caller adds the program to run.
pub(super) fn emulator(toolchain: &Toolchain) -> Command {
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.args(["-machine", toolchain.machine, "-icount", INSTRUCTION_CLOCK]);
    qemu.args(["-display", "none", "-monitor", "none", "-serial", "none"]);
    qemu.args(["-semihosting-config", "enable=on,target=native"]);
    qemu
}

/// Builds a package of the workspace that has one program, for the chip.
///
/// # Errors
/// It does not build.
pub fn build_program(toolchain: &Toolchain, package: &str) -> Result<PathBuf, EmulateError> {
    deadline::run(toolchain.cargo_build().args(["-p", package]), BUILD).map_err(EmulateError::Build)?;
    Ok(toolchain.built(package))
}

/// Builds a package, runs it on the emulated chip and returns what it printed.
///
/// # Errors
/// It does not build, the emulator cannot be run, or the program failed.
pub fn run_program(toolchain: &Toolchain, package: &str) -> Result<String, EmulateError> {
    let program = build_program(toolchain, package)?;
    deadline::run(emulator(toolchain).arg("-kernel").arg(program), RUN).map_err(EmulateError::Run)
}
