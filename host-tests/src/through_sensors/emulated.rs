//! The same sampling path on the emulated chip, and what it takes there.

use super::{Played, on_recorded_times, periods, truth};
use crate::{
    deadline,
    emulate::EmulateError,
    toolchain::{self, Toolchain},
};
use meerkat_mwd::{Sample, sensors::Counters};
use std::{fs, process::Command, time::Duration};

const BUILD: Duration = Duration::from_secs(900);
const RUN: Duration = Duration::from_secs(120);
const RUN_PER_SAMPLE: Duration = Duration::from_millis(10);
/// As the flights run: 64 ns for every instruction.
const INSTRUCTION_CLOCK: &str = "shift=6,sleep=off";
/// Ticks of SysTick at 168 MHz in the 64 ns of an instruction.
const TICKS_PER_INSTRUCTION: f64 = 10.752;

/// Instructions of the sampling path for one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingCost {
    /// Adapters, supervision and combiner.
    pub adapters: f64,
    /// The wires and the models behind them, which a board has hardware for.
    pub wires: f64,
    /// The most that both took for one sample.
    pub most: f64,
}

/// What came out, and what it took.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayedOnTheChip {
    /// The samples as the adapters handed them out, in the parts' time.
    pub raw: Vec<Sample>,
    /// The same at the recording's times.
    pub played: Played,
    /// Instructions.
    pub cost: SamplingCost,
}

/// Plays a recording through models and adapters on the emulated chip.
///
/// # Errors
/// Something is missing, does not build, or fails.
pub fn play_emulated(samples: &[Sample], period_us: u32) -> Result<PlayedOnTheChip, EmulateError> {
    let toolchain = toolchain::prepare()?;
    let image = build(&toolchain, "sensor-bus")?;
    let file = |what| move |source| EmulateError::File { what, source };
    let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
    fs::write(directory.path().join("image"), image).map_err(file("the image cannot be copied"))?;
    let periods = periods(samples, period_us);
    let head = (periods.inertial_us.unwrap_or(period_us), periods.magnetic_us.unwrap_or(period_us));
    let bytes = postcard::to_stdvec(&head)?;
    let bytes = truth(samples, period_us).try_fold(bytes, |bytes, truth| postcard::to_extend(&truth, bytes))?;
    fs::write(directory.path().join("truth.bin"), bytes).map_err(file("the truth cannot be written"))?;

    let mut qemu = Command::new(&toolchain.qemu);
    qemu.current_dir(directory.path());
    qemu.args(["-machine", toolchain.machine, "-icount", INSTRUCTION_CLOCK]);
    qemu.args(["-display", "none", "-monitor", "none", "-serial", "none"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel", "image"]);
    let time = RUN + RUN_PER_SAMPLE.saturating_mul(u32::try_from(samples.len()).unwrap_or(u32::MAX));
    let said = deadline::run(&mut qemu, time).map_err(EmulateError::Run)?;
    let mut rest = &fs::read(directory.path().join("samples.bin")).map_err(file("no samples were written"))?[..];
    let mut raw = Vec::with_capacity(samples.len());
    while !rest.is_empty() {
        let (sample, after) = postcard::take_from_bytes(rest)?;
        raw.push(sample);
        rest = after;
    }
    let played = on_recorded_times(samples, &raw, period_us, [Counters::default(); 2]);
    Ok(PlayedOnTheChip { raw, played, cost: cost(&said) })
}

/// Builds an image of its own package for the chip, or finds it built.
///
/// # Errors
/// It does not build.
pub fn build(toolchain: &Toolchain, package: &str) -> Result<Vec<u8>, EmulateError> {
    let file = |what| move |source| EmulateError::File { what, source };
    let _one_at_a_time =
        toolchain::lock("mwd-firmware.lock").map_err(file("the target directory cannot be written"))?;
    deadline::run(toolchain.cargo_build().args(["-p", package]), BUILD).map_err(EmulateError::Build)?;
    fs::read(toolchain.built(package)).map_err(file("the built image cannot be read"))
}

/// From what the image prints: `truths N ticks T most M wires W`.
fn cost(said: &str) -> SamplingCost {
    let words: Vec<&str> = said.split_whitespace().collect();
    let number = |name: &str| {
        let place = words.iter().position(|word| *word == name);
        place.and_then(|place| words.get(place + 1)?.parse::<f64>().ok()).unwrap_or(f64::NAN)
    };
    let each = |ticks: f64| ticks / TICKS_PER_INSTRUCTION / number("truths");
    SamplingCost {
        adapters: each(number("ticks") - number("wires")),
        wires: each(number("wires")),
        most: number("most") / TICKS_PER_INSTRUCTION,
    }
}
