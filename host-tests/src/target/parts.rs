//! Cost of the parts of an identification on the emulated chip, counted by a plugin of the emulator.

use super::{
    error::EmulateError,
    firmware::{Board, Firmware, build_firmware},
    machine::{BUILD, RUN, RUN_PER_SAMPLE, emulator},
};
use crate::target::{
    deadline,
    image::Image,
    toolchain::{self, Toolchain},
    wire,
};
use meerkat_mwd::{Config, Sample};
use std::{fs, path::Path, process::Command};

/// Source of the plugin, in C because the emulator loads a shared library with a C interface.
const PLUGIN: &str = include_str!("part_counts.c");
/// File name of the built plugin.
const LIBRARY: &str = "part_counts.so";

/// Parts of the firmware's work between samples. Each begins at functions whose mangled names contain all the
/// strings of a group, and lasts until another part begins.
const PARTS: [(&str, &[&[&str]]); 5] = [
    // Everything but identification; it comes first because the count begins with it.
    ("", &[&["5Probe4push"], &["5Probe4poll"], &["17DiagnosisSchedule4step"]]),
    ("increments, and the rows of a node", &[&["9estimator4work", "4take"]]),
    ("filter, and its averaged posterior", &[&["9estimator4work", "4step"]]),
    ("judging a posterior", &[&["10identifier", "5judge"]]),
    ("search", &[&["10identifier", "11step_search"]]),
];

/// A part of the work, and its cost in one run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartCost {
    /// Name of the part.
    pub name: &'static str,
    /// Executed instructions.
    pub instructions: u64,
    /// Processor cycles, estimated from its instruction timings with memory that never waits.
    pub cycles: u64,
}

/// Flies the samples on the emulated chip and counts what the parts of their identifications take.
///
/// # Errors
/// Anything that prevents a whole flight; a part without a function in the firmware; a plugin that does not
/// build.
pub fn count_parts(config: &Config, samples: &[Sample]) -> Result<Vec<PartCost>, EmulateError> {
    config.validate()?;
    let toolchain = toolchain::prepare()?;
    let Firmware { elf, .. } = build_firmware(&toolchain, Board::Trace)?;
    let file = |what| move |source| EmulateError::File { what, source };
    let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
    let path = directory.path();
    fs::write(path.join("probe"), &elf).map_err(file("the firmware cannot be copied"))?;
    let trace = wire::encode_trace(config, None, samples.iter().copied())?;
    fs::write(path.join("trace.bin"), trace).map_err(file("the trace cannot be written"))?;
    build_plugin(&toolchain, path)?;

    let plugin = format!("{}{}", path.join(LIBRARY).display(), entries(&elf)?);
    let mut qemu = emulator(&toolchain);
    qemu.current_dir(path).args(["-kernel", "probe", "-plugin", &plugin]);
    // The plugin counts each block of instructions, which is several times slower.
    let time = (RUN + RUN_PER_SAMPLE.saturating_mul(u32::try_from(samples.len()).unwrap_or(u32::MAX))) * 4;
    deadline::run(&mut qemu, time).map_err(EmulateError::Run)?;
    let counts = fs::read_to_string(path.join("parts.txt")).map_err(file("the plugin wrote no counts"))?;
    parse(&counts).ok_or(EmulateError::Counts(counts))
}

fn build_plugin(toolchain: &Toolchain, directory: &Path) -> Result<(), EmulateError> {
    let source = directory.join("part_counts.c");
    fs::write(&source, PLUGIN).map_err(|source| EmulateError::File { what: "the plugin cannot be written", source })?;
    let said = deadline::run(Command::new(&toolchain.qemu).arg("--version"), BUILD).map_err(EmulateError::Run)?;
    let major = said.split("version ").nth(1).and_then(|rest| rest.split('.').next()?.parse::<u32>().ok());
    // Version of the plugin interface; each emulator accepts a range of versions.
    let version = match major {
        Some(..=8) => 1,
        Some(9) => 2,
        _ => 4,
    };
    let mut compiler = Command::new("gcc");
    compiler.current_dir(directory).args(["-O2", "-shared", "-fPIC", "-o", LIBRARY]);
    compiler.arg(format!("-DPVER={version}")).arg(source);
    deadline::run(&mut compiler, BUILD).map_err(EmulateError::Build)?;
    Ok(())
}

/// Arguments of the plugin: the address of every function at which a part begins.
fn entries(elf: &[u8]) -> Result<String, EmulateError> {
    let image = Image::parse(elf)?;
    let mut arguments = String::new();
    for (number, (name, functions)) in PARTS.into_iter().enumerate() {
        for parts in functions {
            let addresses = image.functions(parts);
            if addresses.is_empty() {
                return Err(EmulateError::NoPart(name));
            }
            for address in addresses {
                arguments += &format!(",part{number:x}={address:x}");
            }
        }
    }
    Ok(arguments)
}

/// Reads the plugin's output: instructions and cycles, one line a part.
fn parse(counts: &str) -> Option<Vec<PartCost>> {
    let line = |(line, (name, _)): (&str, (&'static str, _))| {
        let (instructions, cycles) = line.split_once(' ')?;
        Some(PartCost { name, instructions: instructions.parse().ok()?, cycles: cycles.parse().ok()? })
    };
    let parts: Option<Vec<PartCost>> = counts.lines().zip(PARTS).map(line).collect();
    parts.filter(|parts| parts.len() == PARTS.len()).map(|parts| parts.into_iter().skip(1).collect())
}
