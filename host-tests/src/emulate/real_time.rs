//! The probe's program in real time on the emulated chip: sensors that go on with the clock, telemetry on the serial line.

use super::{Board, EmulateError, Firmware, build_firmware};
use crate::{deadline, through_sensors, toolchain::Toolchain};
use meerkat_mwd::{
    Config, Sample,
    config::SurveyConfig,
    sensor_models::Recording,
    telemetry::{ProbeId, StreamConfig},
};
use std::{collections::BTreeMap, fs, path::Path, process::Command, time::Duration};

/// Which probe the emulated board says it is.
pub const PROBE: ProbeId = ProbeId(*b"emulated 405");

/// A stage of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The interrupt that reads the sensors.
    Acquisition,
    /// Samples to attitudes.
    Samples,
    /// Identification and diagnosis.
    Work,
    /// Frames out, commands in.
    Telemetry,
}

/// What is to be run.
#[derive(Clone, Debug)]
pub struct RealTime {
    /// The probe's configuration.
    pub config: Config,
    /// Its surveys'.
    pub survey: SurveyConfig,
    /// What goes over the serial line.
    pub stream: StreamConfig,
    /// Whether raw samples go over it.
    pub recording: bool,
    /// The key of commands that need one.
    pub key: Option<[u8; 32]>,
    /// A stage that does not end, from a sample on.
    pub hang: Option<(Stage, u32)>,
    /// Words programmed and sectors erased before the power is cut.
    pub power_cut_after: Option<u32>,
    /// An instruction takes 2 to this power nanoseconds. 3 is 125 million a second: 1.34 cycles of 168 MHz each. 4 is 2.7 cycles each, slower
    /// than the chip.
    pub instruction_time: u8,
}

impl Default for RealTime {
    fn default() -> Self {
        Self {
            config: Config::default(),
            survey: SurveyConfig::default(),
            stream: StreamConfig { bytes_per_s: 92_160, ..StreamConfig::default() },
            recording: false,
            key: None,
            hang: None,
            power_cut_after: None,
            instruction_time: 3,
        }
    }
}

/// What a run printed at its end, and sent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Landed {
    /// What the program counted, by name.
    pub values: BTreeMap<String, String>,
    /// Every byte of the serial line.
    pub serial: Vec<u8>,
}

impl Landed {
    /// A count by its name; `None`: it is not there.
    #[must_use]
    pub fn count(&self, name: &str) -> Option<u64> {
        self.values.get(name)?.parse().ok()
    }
}

impl RealTime {
    /// Builds the firmware and runs it over the samples, one each sample period; their own times are not used. They are the truth of register models
    /// of the sensors.
    ///
    /// # Errors
    /// Whatever keeps the program from coming to its end.
    pub fn run(&self, toolchain: &Toolchain, samples: &[Sample], limit: Duration) -> Result<Landed, EmulateError> {
        let firmware = build_firmware(toolchain, Board::Emulated)?;
        let directory = tempfile::tempdir().map_err(file("no temporary directory"))?;
        self.prepare_in(directory.path(), &firmware, samples)?;
        self.run_in(directory.path(), toolchain, limit)
    }

    /// Writes what a run reads: firmware, configuration, sensors' truth. A `flash.bin` that is there (49,152 bytes, erased ones 0xFF) is the memory
    /// of stored models; without one the probe has none.
    ///
    /// # Errors
    /// The directory cannot be written.
    pub fn prepare_in(&self, directory: &Path, firmware: &Firmware, samples: &[Sample]) -> Result<(), EmulateError> {
        let hang = self.hang.map(|(stage, sample)| (stage as u8, sample));
        let (truth, sensors) = self.played(samples);
        let what =
            (self.config, self.survey, self.stream, self.recording, self.key, sensors, hang, self.power_cut_after);
        let boot = postcard::to_stdvec(&what)?;
        fs::write(directory.join("probe"), &firmware.elf).map_err(file("the firmware cannot be copied"))?;
        fs::write(directory.join("boot.bin"), boot).map_err(file("the configuration cannot be written"))?;
        let truth: Vec<u8> = truth.iter().flat_map(record).collect();
        fs::write(directory.join("sensors.bin"), truth).map_err(file("the sensors' file cannot be written"))
    }

    /// The truth of the sensors, one sample each sample period, and how it is played.
    fn played(&self, samples: &[Sample]) -> (Vec<Sample>, Recording) {
        let period_us = self.config.sample_period_us;
        let timed: Vec<Sample> = (samples.iter().zip(1_u64..))
            .map(|(sample, k)| Sample { t_us: k * u64::from(period_us), ..*sample })
            .collect();
        (through_sensors::truth(&timed), through_sensors::recording(&timed, period_us))
    }

    /// What the adapters make of the samples there, and so what flies: the same on this machine.
    #[must_use]
    pub fn through_sensors(&self, samples: &[Sample]) -> Vec<Sample> {
        through_sensors::play(&self.played(samples).0, self.config.sample_period_us).samples
    }

    /// Runs what was prepared, the serial line kept in `serial.bin`.
    ///
    /// # Errors
    /// Whatever keeps the program from coming to its end.
    pub fn run_in(&self, directory: &Path, toolchain: &Toolchain, limit: Duration) -> Result<Landed, EmulateError> {
        let mut qemu = self.emulator(directory, toolchain, "file:serial.bin");
        let printed = deadline::run(&mut qemu, limit).map_err(EmulateError::Run)?;
        let values = printed.lines().filter_map(|line| line.split_once(" = "));
        let values = values.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
        let serial = fs::read(directory.join("serial.bin")).map_err(file("the serial line was not kept"))?;
        Ok(Landed { values, serial })
    }

    /// The emulator over what was prepared, its serial line on what QEMU calls a character device, such as
    /// `unix:PATH,server=on,wait=on`.
    #[must_use]
    pub fn emulator(&self, directory: &Path, toolchain: &Toolchain, serial: &str) -> Command {
        let mut qemu = Command::new(&toolchain.qemu);
        qemu.current_dir(directory);
        qemu.args(["-machine", toolchain.machine, "-icount"]);
        qemu.arg(format!("shift={},sleep=off", self.instruction_time));
        qemu.args(["-display", "none", "-monitor", "none", "-serial", serial]);
        qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel", "probe"]);
        qemu
    }
}

/// What a file that cannot be read or written is to a run.
fn file(what: &'static str) -> impl FnOnce(std::io::Error) -> EmulateError {
    move |source| EmulateError::File { what, source }
}

/// Ten numbers and the flags, little-endian.
fn record(sample: &Sample) -> Vec<u8> {
    let vectors = [sample.gyro_rad_s, sample.accel_m_s2, sample.mag_ut];
    let numbers = vectors.iter().flatten().chain([&sample.temperature_c]);
    numbers.flat_map(|number| number.to_le_bytes()).chain(sample.flags.bits().to_le_bytes()).collect()
}
