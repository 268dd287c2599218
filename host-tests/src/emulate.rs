//! The same flight, by the firmware on the emulated chip.

mod firmware;
mod parts;
pub mod real_time;

pub use firmware::{Board, Firmware, build_firmware};
pub use parts::{PartCost, count_parts};

use crate::{
    cli::ReplayArgs,
    deadline::{self, CommandError},
    flight::Flight,
    image::{ImageError, ImageSize},
    replay,
    through_sensors::{self, SamplingCost},
    toolchain::{self, Missing, Toolchain},
    wire::{self, WireError},
};
use clap::Args;
use meerkat_mwd::{Config, Sample, config::ConfigError, sensor_models::PlayedCounts, telemetry::Summary};
use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
    process::Command,
    time::Duration,
};

/// A cold build takes some ten seconds.
const BUILD: Duration = Duration::from_secs(900);
/// Start of the emulator, and a share for each sample that no identification comes near.
const RUN: Duration = Duration::from_secs(120);
const RUN_PER_SAMPLE: Duration = Duration::from_millis(10);
/// 64 ns for every instruction: time then depends on the instructions alone, and 168 MHz ticks resolve single ones.
const INSTRUCTION_CLOCK: &str = "shift=6,sleep=off";

/// A flight on the emulated chip, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct EmulatedFlight {
    /// What the host's run gives too, bit for bit.
    pub flight: Flight,
    /// Instructions in `Probe::poll` for each of the flight's reports.
    pub poll_instructions: Vec<u64>,
    /// Instructions and stack of the run.
    pub summary: Summary,
    /// RAM and flash of the firmware.
    pub image: ImageSize,
    /// What the sampling path took, where the samples came through the sensors' models.
    pub sampling: Option<SamplingCost>,
}

impl EmulatedFlight {
    /// Instructions, stack and memory, for a reader.
    #[must_use]
    pub fn cost_lines(&self) -> Vec<String> {
        let Self { summary, image, .. } = self;
        let thousands = |n: u64| {
            let digits = n.to_string();
            let groups: Vec<&str> =
                digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
            groups.join(",")
        };
        let identifications: Vec<u64> = (self.flight.reports.iter().zip(&self.poll_instructions))
            .filter_map(|(report, instructions)| (report.evaluations > 0).then_some(*instructions))
            .collect();
        let per_identification = match (identifications.iter().min(), identifications.iter().max()) {
            (Some(least), Some(most)) => format!("{} to {}", thousands(*least), thousands(*most)),
            _ => "none was made".to_owned(),
        };
        let (mean, most) = (summary.push.instructions_mean(), summary.push.instructions_max);
        let mut lines = vec![
            format!(
                "cost     {} instructions a sample (worst {}), {per_identification} of identification and diagnosis to a report",
                thousands(mean),
                thousands(most)
            ),
            format!("         longest slice of that work {} instructions", thousands(summary.poll.instructions_max)),
            format!(
                "memory   {image}; stack {} of {} bytes",
                thousands(summary.stack_used_bytes.into()),
                thousands(summary.stack_size_bytes.into())
            ),
        ];
        if let Some(SamplingCost { adapters, wires, .. }) = self.sampling {
            let line = format!(
                "sampling {} instructions a sample for adapters and supervision, {} for wires and models",
                thousands(adapters.round() as u64),
                thousands(wires.round() as u64)
            );
            lines.insert(2, line);
        }
        lines
    }
}

/// Why there is no emulated flight.
#[derive(Debug, thiserror::Error)]
pub enum EmulateError {
    /// Something that is needed is not there.
    #[error(transparent)]
    Missing(#[from] Missing),
    /// The configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The firmware does not build.
    #[error("the firmware cannot be built: {0}")]
    Build(CommandError),
    /// What was built is not an image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file could not be read or written.
    #[error("{what}: {source}")]
    File {
        /// What was being done.
        what: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The trace has no encoding.
    #[error("the trace cannot be encoded: {0}")]
    Encode(#[from] postcard::Error),
    /// The emulator, or the firmware in it, failed.
    #[error("the emulated firmware failed: {0}")]
    Run(CommandError),
    /// The samples that came through the sensors there are not those that come through them here.
    #[error("the samples came through the sensors otherwise than on this machine: {there:?}, here {here:?}")]
    Sensors {
        /// What the firmware counted.
        there: Option<PlayedCounts>,
        /// What was counted here.
        here: PlayedCounts,
    },
    /// The firmware has no function of a part that is to be counted.
    #[error("no function of the firmware's belongs to the part {0:?}")]
    NoPart(&'static str),
    /// The counts of the parts are none.
    #[error("the emulator's plugin wrote no counts: {0:?}")]
    Counts(String),
    /// What the firmware wrote is not a flight.
    #[error("the emulated firmware wrote no whole flight: {0}")]
    Wire(#[from] WireError),
}

impl EmulateError {
    /// Exit status of a program that stops for this.
    #[must_use]
    pub const fn exit_status(&self) -> u8 {
        match self {
            Self::Missing(_) => Missing::EXIT_STATUS,
            Self::Config(_) => 2,
            _ => 1,
        }
    }
}

/// Options of `emulate`.
#[derive(Debug, Clone, Args)]
pub struct EmulateArgs {
    /// Those of `replay`.
    #[command(flatten)]
    pub replay: ReplayArgs,
    /// Hand the samples over instead, as `replay` does
    #[arg(long, conflicts_with = "through_sensors")]
    pub direct: bool,
}

/// How a recording reaches the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// Each sample is handed over as it was recorded.
    Direct,
    /// The recording is the truth of register models of the sensors, and the adapters that fly with real ones read these.
    ThroughSensors,
}

/// Flies the samples on the emulated chip. Prepares the toolchain and builds the firmware first.
///
/// # Errors
/// Whatever keeps it from a whole flight.
pub fn fly_emulated(config: &Config, samples: &[Sample], feed: Feed) -> Result<EmulatedFlight, EmulateError> {
    config.validate()?;
    let toolchain = toolchain::prepare()?;
    let firmware = build_firmware(&toolchain, Board::Trace)?;
    let period_us = config.sample_period_us;
    let trace = match feed {
        Feed::Direct => wire::encode_trace(config, None, samples.iter().copied())?,
        Feed::ThroughSensors => {
            let recording = through_sensors::recording(samples, period_us);
            wire::encode_trace(config, Some(recording), through_sensors::truth(samples))?
        }
    };
    let time = RUN + RUN_PER_SAMPLE.saturating_mul(u32::try_from(samples.len()).unwrap_or(u32::MAX));
    let (bytes, said) = run_firmware(&toolchain, &firmware, &trace, time)?;
    let landed = wire::decode_flight(&bytes)?;
    Ok(EmulatedFlight {
        flight: landed.flight,
        poll_instructions: landed.poll_instructions,
        summary: landed.summary,
        image: firmware.size,
        sampling: SamplingCost::said(&said),
    })
}

/// Runs the firmware over the bytes of a `trace.bin` and gives those of its `flight.bin`, and what it printed.
///
/// # Errors
/// The emulator cannot be run, was stopped after `time`, or the firmware ended with a message.
pub fn run_firmware(
    toolchain: &Toolchain,
    firmware: &Firmware,
    trace: &[u8],
    time: Duration,
) -> Result<(Vec<u8>, String), EmulateError> {
    let file = |what| move |source| EmulateError::File { what, source };
    let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
    fs::write(directory.path().join("probe"), &firmware.elf).map_err(file("the firmware cannot be copied"))?;
    fs::write(directory.path().join("trace.bin"), trace).map_err(file("the trace cannot be written"))?;

    let mut qemu = emulator(toolchain);
    qemu.current_dir(directory.path()).args(["-kernel", "probe"]);
    let said = deadline::run(&mut qemu, time).map_err(EmulateError::Run)?;
    let flight = fs::read(directory.path().join("flight.bin")).map_err(file("the firmware wrote no flight"))?;
    Ok((flight, said))
}

fn emulator(toolchain: &Toolchain) -> Command {
    let mut qemu = Command::new(&toolchain.qemu);
    qemu.args(["-machine", toolchain.machine, "-icount", INSTRUCTION_CLOCK]);
    qemu.args(["-display", "none", "-monitor", "none", "-serial", "none"]);
    qemu.args(["-semihosting-config", "enable=on,target=native"]);
    qemu
}

/// Builds a package of the workspace whose one program is for the chip.
///
/// # Errors
/// It does not build.
pub fn build_program(toolchain: &Toolchain, package: &str) -> Result<PathBuf, EmulateError> {
    deadline::run(toolchain.cargo_build().args(["-p", package]), BUILD).map_err(EmulateError::Build)?;
    Ok(toolchain.built(package))
}

/// Builds such a package, runs it on the chip and gives what it printed.
///
/// # Errors
/// It does not build, the emulator cannot be run, or the program failed.
pub fn run_program(toolchain: &Toolchain, package: &str) -> Result<String, EmulateError> {
    let program = build_program(toolchain, package)?;
    deadline::run(emulator(toolchain).arg("-kernel").arg(program), RUN).map_err(EmulateError::Run)
}

/// Flies the trace on the emulated chip and delivers what `replay` delivers, and what it cost there.
///
/// # Errors
/// Bad input or usage, or whatever keeps the emulator from a whole flight.
pub fn run(EmulateArgs { replay: args, direct }: &EmulateArgs) -> anyhow::Result<()> {
    let (mut trace, config) = replay::prepare(args)?;
    let feed = if *direct { Feed::Direct } else { Feed::ThroughSensors };
    let recorded = if *direct { trace.samples.clone() } else { through_sensors::each_field_once(&trace.samples) };
    let emulated = fly_emulated(&config, &recorded, feed)?;
    let played = (!direct).then(|| through_sensors::play(&recorded, config.sample_period_us));
    if let Some(played) = &played {
        let (there, here) = (emulated.sampling.map(|sampling| sampling.counts), played.counts);
        if there != Some(here) {
            return Err(EmulateError::Sensors { there, here }.into());
        }
        trace.samples.clone_from(&played.samples);
    }
    replay::deliver(args, &trace, &config, &emulated.flight, "by the firmware on the emulated Cortex-M4F")?;
    let mut out = io::stdout().lock();
    for line in emulated.cost_lines() {
        writeln!(out, "{line}")?;
    }
    if let Some(played) = &played {
        through_sensors::report(&mut out, &config, &recorded, played)?;
    }
    Ok(())
}
