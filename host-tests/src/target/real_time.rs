//! The probe's program in real time on the emulated chip: sensors follow the clock, telemetry goes to the
//! serial line.

use super::{
    error::EmulateError,
    firmware::{Board, Firmware, build_firmware},
};
use crate::target::{deadline, toolchain::Toolchain};
use meerkat_mwd::{
    Config, Sample,
    emulation::Recording,
    telemetry::{ProbeId, StreamConfig},
};
use std::{collections::BTreeMap, fs, path::Path, process::Command, time::Duration};
use testbed::flight::through_sensors;

/// The machine that a loader runs on.
const MPS2: &str = "mps2-an386";

/// Identity that the emulated board states.
pub const PROBE: ProbeId = ProbeId(*b"emulated 405");

/// A stage of the probe's program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The interrupt that reads the sensors.
    Acquisition,
    /// Computes attitudes from samples.
    Samples,
    /// Does identification and diagnosis.
    Work,
    /// Sends frames and receives commands.
    Telemetry,
}

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct RealTime {
    /// The probe's configuration.
    pub config: Config,
    /// Settings of the telemetry stream.
    pub stream: StreamConfig,
    /// True if raw samples are sent.
    pub recording: bool,
    /// The key of commands that need one.
    pub key: Option<[u8; 32]>,
    /// A stage that hangs, and the sample from which on it does.
    pub hang: Option<(Stage, u32)>,
    /// Number of flash operations (words programmed, sectors erased) before the power is cut.
    pub power_cut_after: Option<u32>,
    /// Time of an instruction: 2 to this power nanoseconds. 3 is 125 million instructions a second, 1.34
    /// cycles of 168 MHz each; 4 is 2.7 cycles each, slower than the chip.
    pub instruction_time: u8,
    /// True if a loader on the MPS2 starts one of the images of `images.bin`, instead of the program alone.
    pub by_loader: bool,
}

impl Default for RealTime {
    fn default() -> Self {
        Self {
            config: Config::default(),
            stream: StreamConfig { bytes_per_s: 92_160, ..StreamConfig::default() },
            recording: false,
            key: None,
            hang: None,
            power_cut_after: None,
            instruction_time: 3,
            by_loader: false,
        }
    }
}

/// Output of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Landed {
    /// Counts that the program printed at its end, by name.
    pub values: BTreeMap<String, String>,
    /// Every byte sent over the serial line.
    pub serial: Vec<u8>,
}

impl Landed {
    /// A count by its name; `None` if there is none.
    #[must_use]
    pub fn count(&self, name: &str) -> Option<u64> {
        self.values.get(name)?.parse().ok()
    }
}

impl RealTime {
    /// Builds the firmware and runs it. Register models of the sensors measure one sample each sample period;
    /// the samples' own times are not used.
    ///
    /// # Errors
    /// Anything that prevents the program from reaching its end.
    pub fn run(&self, toolchain: &Toolchain, samples: &[Sample], limit: Duration) -> Result<Landed, EmulateError> {
        let firmware = build_firmware(toolchain, Board::Emulated)?;
        let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
        self.prepare_in(directory.path(), &firmware, samples)?;
        self.run_in(directory.path(), toolchain, limit)
    }

    /// Writes the files of a run: firmware, configuration, the sensors' truth. If the directory holds a
    /// `flash.bin` (49,152 bytes, 0xFF if erased), it is the flash of stored models; else there is none.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn prepare_in(&self, directory: &Path, firmware: &Firmware, samples: &[Sample]) -> Result<(), EmulateError> {
        let hang = self.hang.map(|(stage, sample)| (stage as u8, sample));
        let (truth, sensors) = self.played(samples);
        let what = (self.config, self.stream, self.recording, self.key, sensors, hang, self.power_cut_after);
        let boot = postcard::to_stdvec(&what)?;
        fs::write(directory.join("probe"), &firmware.elf).map_err(file("the firmware cannot be copied"))?;
        fs::write(directory.join("boot.bin"), boot).map_err(file("the configuration cannot be written"))?;
        let truth: Vec<u8> = truth.iter().flat_map(record).collect();
        fs::write(directory.join("sensors.bin"), truth).map_err(file("the sensors' file cannot be written"))
    }

    /// Truth for the sensors, one sample each sample period, and how it is played.
    fn played(&self, samples: &[Sample]) -> (Vec<Sample>, Recording) {
        let period_us = self.config.sample_period_us;
        let timed: Vec<Sample> = (samples.iter().zip(1_u64..))
            .map(|(sample, k)| Sample { t_us: k * u64::from(period_us), ..*sample })
            .collect();
        (through_sensors::truth(&timed), through_sensors::recording(&timed, period_us))
    }

    /// Samples that the adapters deliver, on the chip and on this machine alike: what flies.
    #[must_use]
    pub fn through_sensors(&self, samples: &[Sample]) -> Vec<Sample> {
        through_sensors::play(&self.played(samples).0, self.config.sample_period_us).samples
    }

    /// Runs the prepared program and stores the serial line in `serial.bin`.
    ///
    /// # Errors
    /// Anything that prevents the program from reaching its end.
    pub fn run_in(&self, directory: &Path, toolchain: &Toolchain, limit: Duration) -> Result<Landed, EmulateError> {
        let mut qemu = self.emulator(directory, toolchain, "file:serial.bin");
        let printed = deadline::run(&mut qemu, limit).map_err(EmulateError::Run)?;
        let values = printed.lines().filter_map(|line| line.split_once(" = "));
        let values = values.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
        let serial = fs::read(directory.join("serial.bin")).map_err(file("the serial line was not kept"))?;
        Ok(Landed { values, serial })
    }

    /// The emulator command for the prepared files, with its serial line on a QEMU character device such as
    /// `unix:PATH,server=on,wait=on`.
    #[must_use]
    pub fn emulator(&self, directory: &Path, toolchain: &Toolchain, serial: &str) -> Command {
        let mut qemu = Command::new(&toolchain.qemu);
        qemu.current_dir(directory);
        let (machine, program) = if self.by_loader { (MPS2, "loader") } else { (toolchain.machine, "probe") };
        qemu.args(["-machine", machine, "-icount"]);
        qemu.arg(format!("shift={},sleep=off", self.instruction_time));
        qemu.args(["-display", "none", "-monitor", "none", "-serial", serial]);
        qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel", program]);
        qemu
    }
}

/// Makes an error of a file that cannot be read or written.
fn file(what: &'static str) -> impl FnOnce(std::io::Error) -> EmulateError {
    move |source| EmulateError::File { what, source }
}

/// A sample as ten numbers and flags, little-endian.
fn record(sample: &Sample) -> Vec<u8> {
    let vectors = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
    let numbers = vectors.iter().flatten().chain([&sample.temperature_c]);
    numbers.flat_map(|number| number.to_le_bytes()).chain(sample.flags.bits().to_le_bytes()).collect()
}
