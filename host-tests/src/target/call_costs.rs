//! Cost of the firmware's calls on the emulated chip, in cycles, counted by a plugin of the emulator.

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
const PLUGIN: &str = include_str!("call_costs.c");
/// File name of the built plugin.
const LIBRARY: &str = "call_costs.so";

/// A kind of call that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// A sample's way through the pipeline.
    Sample,
    /// Work beside samples after one of them; its period ends with a window's report.
    Work,
    /// A piece of the estimator's work.
    Piece,
    /// A piece of the search.
    Searching,
    /// Judgement of an update.
    Judging,
    /// A node's rows and their way into the root; its period is a node.
    Node,
    /// An increment, with the effects' terms; a node's rows where one ends with it.
    Increment,
    /// A node's rows alone.
    Rows,
    /// Elimination of a node's states from its rows.
    Eliminating,
    /// Way of what is left into the globals.
    Absorbing,
    /// Way of the rest into the effects' own rows.
    AbsorbingOwn,
    /// Random walks of the globals.
    Walking,
    /// Average of the posterior over widths.
    Averaging,
    /// Bound of a search's cost.
    Bounding,
    /// Weighing of the effects.
    Weighing,
}

/// Name of a function: all of these strings are in its mangled name.
type Name = &'static [&'static str];

/// Functions of the estimator's pieces of work.
const END_NODE: Name = &["9estimator8node_end", "2of17h"];
const ELIMINATE: Name = &["9estimator10candidates4root", "9eliminate17h"];
const ABSORB: Name = &["9estimator6filter", "6absorb17h"];
const ABSORB_OWN: Name = &["9estimator6filter", "10absorb_own17h"];
const AVERAGE: [Name; 4] = [
    &["9estimator7closing", "5start17h"],
    &["9estimator7closing", "6gather17h"],
    &["9estimator7closing", "7inflate17h"],
    &["9estimator7closing", "3mix17h"],
];

/// Kinds of call, the functions of each, and the function at whose entry its period ends.
const CALLS: [(Call, &[Name], Option<Name>); 15] = [
    (Call::Sample, &[&["11push_sample17h"]], None),
    (Call::Work, &[&["10poll_probe17h"]], Some(&["12write_window17h"])),
    (Call::Piece, &[&["Estimator$LT$", "$GT$4step17h"]], None),
    (Call::Searching, &[&["10identifier", "11step_search17h"]], None),
    (Call::Judging, &[&["10identifier", "5judge17h"]], None),
    (Call::Node, &[END_NODE, ELIMINATE, ABSORB, ABSORB_OWN], Some(END_NODE)),
    (Call::Increment, &[&["9estimator6filter", "4take17h"]], None),
    (Call::Rows, &[END_NODE], None),
    (Call::Eliminating, &[ELIMINATE], None),
    (Call::Absorbing, &[ABSORB], None),
    (Call::AbsorbingOwn, &[ABSORB_OWN], None),
    (Call::Walking, &[&["9estimator6filter", "17add_process_noise17h"], &["9estimator6filter", "4walk17h"]], None),
    (Call::Averaging, &AVERAGE, None),
    (
        Call::Bounding,
        &[&["9estimator7closing", "10put_centre17h"], &["9estimator11window_cost", "13bound_by_rows17h"]],
        None,
    ),
    (Call::Weighing, &[&["9estimator6filter", "5weigh17h"]], None),
];

/// Cost of a call, or of several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Executed instructions.
    pub instructions: u64,
    /// Processor cycles, estimated from its instruction timings with memory that never waits.
    pub cycles: u64,
    /// Products of floats, alone or with a sum.
    pub products: u64,
    /// Cycles of arithmetic of floats.
    pub arithmetic: u64,
    /// Cycles of loads and stores.
    pub memory: u64,
}

/// Calls of one kind in one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calls {
    /// Number of calls.
    pub count: u64,
    /// All calls together.
    pub sum: Cost,
    /// The dearest call.
    pub most: Cost,
    /// Number of periods that ended.
    pub periods: u64,
    /// All calls of the dearest period.
    pub most_of_period: Cost,
}

/// Calls of a run, by their kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CallCosts([Calls; CALLS.len()]);

impl CallCosts {
    /// Calls of a kind.
    #[must_use]
    pub fn of(&self, call: Call) -> Calls {
        let all = CALLS.iter().zip(self.0);
        all.into_iter().find(|((kind, ..), _)| *kind == call).map_or_else(Calls::default, |(_, calls)| calls)
    }
}

/// Flies the samples on the emulated chip and counts what its calls cost.
///
/// # Errors
/// Anything that prevents a whole flight; a call without a function in the firmware; a plugin that does not build.
pub fn count_calls(config: &Config, samples: &[Sample]) -> Result<CallCosts, EmulateError> {
    config.validate()?;
    let toolchain = toolchain::prepare()?;
    let Firmware { elf, .. } = build_firmware(&toolchain, Board::Trace)?;
    let file = |what| move |source| EmulateError::File { what, source };
    let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
    let path = directory.path();
    fs::write(path.join("probe"), &elf).map_err(file("the firmware cannot be copied"))?;
    let trace = wire::encode_trace(config, None, None, samples.iter().copied())?;
    fs::write(path.join("trace.bin"), trace).map_err(file("the trace cannot be written"))?;
    build_plugin(&toolchain, path)?;

    let plugin = format!("{}{}", path.join(LIBRARY).display(), entries(&elf)?);
    let mut qemu = emulator(&toolchain);
    qemu.current_dir(path).args(["-kernel", "probe", "-plugin", &plugin]);
    // The plugin counts each block of instructions, which is several times slower.
    let time = (RUN + RUN_PER_SAMPLE.saturating_mul(u32::try_from(samples.len()).unwrap_or(u32::MAX))) * 4;
    deadline::run(&mut qemu, time).map_err(EmulateError::Run)?;
    let counts = fs::read_to_string(path.join("costs.txt")).map_err(file("the plugin wrote no counts"))?;
    parse(&counts).ok_or(EmulateError::Counts(counts))
}

/// Runs a program in the emulator `qemu`, which the caller has told all but the plugin, in a directory, and counts the
/// calls of the function whose mangled name has all of these strings. Returns with them what the program printed.
///
/// # Errors
/// The program has no such function or does not end; a plugin that does not build.
pub fn count_function(
    toolchain: &Toolchain,
    qemu: &mut Command,
    elf: &[u8],
    name: &[&str],
    directory: &Path,
) -> Result<(String, Calls), EmulateError> {
    let file = |what| move |source| EmulateError::File { what, source };
    let address = *Image::parse(elf)?.functions(name).first().ok_or_else(|| EmulateError::NoCall(name.concat()))?;
    build_plugin(toolchain, directory)?;
    let plugin = format!("{},call0={address:x}", directory.join(LIBRARY).display());
    qemu.current_dir(directory).args(["-plugin", &plugin]);
    let printed = deadline::run(qemu, RUN * 4).map_err(EmulateError::Run)?;
    let counts = fs::read_to_string(directory.join("costs.txt")).map_err(file("the plugin wrote no counts"))?;
    let calls = counts.lines().next().and_then(calls).ok_or(EmulateError::Counts(counts))?;
    Ok((printed, calls))
}

fn build_plugin(toolchain: &Toolchain, directory: &Path) -> Result<(), EmulateError> {
    let source = directory.join("call_costs.c");
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

/// Arguments of the plugin: the addresses of all functions at which calls begin or periods end.
fn entries(elf: &[u8]) -> Result<String, EmulateError> {
    let image = Image::parse(elf)?;
    let mut arguments = String::new();
    for (number, (_, functions, period)) in CALLS.into_iter().enumerate() {
        let calls = functions.iter().map(|name| ("call", *name));
        for (word, name) in calls.chain(period.map(|name| ("period", name))) {
            let addresses = image.functions(name);
            if addresses.is_empty() {
                return Err(EmulateError::NoCall(name.concat()));
            }
            for address in addresses {
                arguments += &format!(",{word}{number:x}={address:x}");
            }
        }
    }
    Ok(arguments)
}

/// Reads the plugin's output: one line a kind of call.
fn parse(counts: &str) -> Option<CallCosts> {
    let mut all = [Calls::default(); CALLS.len()];
    let mut lines = counts.lines();
    for of_kind in &mut all {
        *of_kind = calls(lines.next()?)?;
    }
    lines.next().is_none().then_some(CallCosts(all))
}

fn calls(line: &str) -> Option<Calls> {
    let mut numbers = line.split(' ').map(str::parse::<u64>);
    let mut next = || numbers.next()?.ok();
    Some(Calls {
        count: next()?,
        sum: cost(&mut next)?,
        most: cost(&mut next)?,
        periods: next()?,
        most_of_period: cost(&mut next)?,
    })
}

fn cost(next: &mut impl FnMut() -> Option<u64>) -> Option<Cost> {
    Some(Cost { instructions: next()?, cycles: next()?, products: next()?, arithmetic: next()?, memory: next()? })
}
