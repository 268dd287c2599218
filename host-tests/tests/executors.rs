//! The library under executors, on the emulated chip and on this machine.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "rig/emulator.rs"]
mod emulator;

use mwd::target::{deadline, machine::build_program, toolchain::workspace};
use object::{Object, ObjectSection, SectionKind};
use std::{fs, process::Command, time::Duration};

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

/// Data memory of a VA41630, two banks one behind the other, and its memory for code (`examples/va416xx/va416xx.x`).
const VA41630_RAM: std::ops::Range<u64> = 0x1FFF_8000..0x2000_8000;
const VA41630_CODE: u64 = 256 * 1024;
/// Stack that the attitude tier uses, and half as much again (`tests/tiers.rs` measures it).
const STACK: u64 = 8 * 1024;

/// A part for high temperatures: the image is linked with its own HAL, and fits. Nothing emulates it.
#[test]
fn the_attitude_tier_fits_a_va41630() {
    let Some(toolchain) = emulator::toolchain() else { return };
    let elf = fs::read(build_program(&toolchain, "va416xx-probe").unwrap()).unwrap();
    let file = object::read::elf::ElfFile32::<object::Endianness>::parse(&*elf).unwrap();
    let (mut ram, mut code) = (0, 0);
    for section in file.sections().filter(|section| section.size() > 0) {
        match section.kind() {
            SectionKind::UninitializedData => ram += section.size(),
            SectionKind::Data => (ram, code) = (ram + section.size(), code + section.size()),
            SectionKind::Text | SectionKind::ReadOnlyData => code += section.size(),
            _ => {}
        }
    }
    println!("code {code} of {VA41630_CODE} bytes, static RAM {ram} of {}", VA41630_RAM.end - VA41630_RAM.start);
    assert!(code > 40_000 && ram > 7_000, "it was linked with all of it");
    assert!(code <= VA41630_CODE && ram + STACK <= VA41630_RAM.end - VA41630_RAM.start);
}
