//! A flight by the firmware on the emulated chip.

use std::{fs, time::Duration};

use meerkat_mwd::{Config, Sample, emulation::Summary};

use super::{
    deadline,
    error::EmulateError,
    firmware::{Board, Firmware, build_firmware},
    image::ImageSize,
    machine::{RUN, RUN_PER_SAMPLE, emulator},
    toolchain::{self, Toolchain},
    wire,
};
use testbed::flight::{
    Flight,
    through_sensors::{self, SamplingCost},
};

/// A flight on the emulated chip, and its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct EmulatedFlight {
    /// The flight; equal to the host's, bit for bit.
    pub flight: Flight,
    /// Instructions in `Probe::poll` for each of the flight's reports.
    pub poll_instructions: Vec<u64>,
    /// Instructions and stack of the run.
    pub summary: Summary,
    /// RAM and flash of the firmware.
    pub image: ImageSize,
    /// Cost of the sampling path, if the samples came through the sensor models.
    pub sampling: Option<SamplingCost>,
}

impl EmulatedFlight {
    /// Instructions, stack and memory, as lines for the summary.
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

/// Way in which a recording reaches the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feed {
    /// The firmware is given each sample as recorded.
    Direct,
    /// Register models of the sensors measure the recording, and the adapters that fly with real sensors read
    /// the models.
    ThroughSensors,
}

/// Flies the samples on the emulated chip; from `freeze_at_us` on nothing new takes effect. Prepares the toolchain and
/// builds the firmware first.
///
/// # Errors
/// Anything that prevents a whole flight; see [`EmulateError`].
pub fn fly_emulated(
    config: &Config,
    freeze_at_us: Option<u64>,
    samples: &[Sample],
    feed: Feed,
) -> Result<EmulatedFlight, EmulateError> {
    config.validate()?;
    let toolchain = toolchain::prepare()?;
    let firmware = build_firmware(&toolchain, Board::Trace)?;
    let period_us = config.sample_period_us;
    let trace = match feed {
        Feed::Direct => wire::encode_trace(config, freeze_at_us, None, samples.iter().copied())?,
        Feed::ThroughSensors => {
            let recording = through_sensors::recording(samples, period_us);
            wire::encode_trace(config, freeze_at_us, Some(recording), through_sensors::truth(samples))?
        }
    };
    let time = RUN + RUN_PER_SAMPLE.saturating_mul(u32::try_from(samples.len()).unwrap_or(u32::MAX));
    let (bytes, said) = run_firmware(&toolchain, &firmware, &trace, time)?;
    let landed = wire::decode_flight(&bytes)?;
    Ok(EmulatedFlight {
        flight: Flight { frozen_at_us: freeze_at_us, ..landed.flight },
        poll_instructions: landed.poll_instructions,
        summary: landed.summary,
        image: firmware.size,
        sampling: SamplingCost::said(&said),
    })
}

/// Runs the firmware on the bytes of a `trace.bin`; returns those of its `flight.bin`, and what it printed.
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
