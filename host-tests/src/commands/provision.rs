//! `mwd provision`: write the factory's records into a probe, once, and read them back.

use std::{
    io::Write,
    path::{Path, PathBuf},
    time::Duration,
};

use clap::{ArgGroup, Args};
use meerkat_mwd::{
    Config,
    storage::{FactoryCalibration, FactoryRecord, Mounting},
    telemetry::{Command, CommandRefusal, Outcome},
};

use super::{
    command::{heard, no_answer, send_counting},
    toml_file,
};
use crate::port::{
    key_file::KeyFile,
    line::{Line, LineArgs},
};
use testbed::{console::stdout, failure::Failure};

/// Options of `provision`.
#[derive(Debug, Clone, Args)]
#[command(group(ArgGroup::new("records").args(["calibration", "toolface_offset", "key"]).required(true).multiple(true)))]
pub struct ProvisionArgs {
    /// Port of the probe.
    #[command(flatten)]
    pub line: LineArgs,
    /// Calibration of gyro, accelerometer and magnetometer: tables [accel] and [mag] as `calibrate` writes them, and
    /// [gyro]
    #[arg(long, value_name = "FILE.toml", requires = "serial")]
    pub calibration: Option<PathBuf>,
    /// Serial number of the probe, written with the calibration
    #[arg(long, value_name = "N", requires = "calibration")]
    pub serial: Option<u32>,
    /// Degrees from the probe's x axis to the mark of its housing, added to every toolface
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub toolface_offset: Option<f32>,
    /// File with the probe's key, 64 hexadecimal digits. It is written last: with it the probe is closed
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Write nothing; compare what the probe holds
    #[arg(long)]
    pub check: bool,
    /// Seconds to wait for each answer
    #[arg(long, value_name = "S", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3_600))]
    pub deadline: u64,
}

/// Identity of the gyro, as a file has it.
const GYRO: &str = "[gyro]\np = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\nb_rad_s = [0.0, 0.0, 0.0]";
/// The same of the vector sensors, without the names of their tables.
const VECTOR: &str = "matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]\noffset = [0.0, 0.0, 0.0]";

/// The calibration of a file, which has all three sensors: what is written into a probe stays for ever, and a file of
/// something else must not pass for three identities.
fn calibration(path: &Path, serial_number: u32) -> Result<FactoryCalibration, Failure> {
    let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
    let table: toml::Table = toml_file::read(path)?;
    let missing: Vec<&str> = ["gyro", "accel", "mag"].into_iter().filter(|name| !table.contains_key(*name)).collect();
    if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|name| format!("[{name}]")).collect();
        let identity = |name: &&str| if *name == "gyro" { GYRO.to_owned() } else { format!("[{name}]\n{VECTOR}") };
        let identities: Vec<String> = missing.iter().map(identity).collect();
        return Err(bad(format!(
            "no {}, and what is written into a probe stays for ever. `cargo mwd calibrate TRACE... -o FILE.toml` makes \
             [accel] and [mag]; if a sensor is to fly as it reads, write that out:\n{}",
            names.join(" and no "),
            identities.join("\n")
        )));
    }
    let Config { gyro, accel, mag, .. } =
        table.try_into().map_err(|error: toml::de::Error| bad(error.to_string().trim_end().replace('\n', " ")))?;
    Ok(FactoryCalibration { gyro, accel, mag, serial_number })
}

/// The records, in the order in which they are written, with their names.
fn records(args: &ProvisionArgs) -> Result<Vec<(&'static str, FactoryRecord)>, Failure> {
    let mut records = Vec::new();
    if let (Some(path), Some(serial_number)) = (&args.calibration, args.serial) {
        let calibration = calibration(path, serial_number)?;
        if !calibration.is_valid() {
            return Err(Failure::BadInput(format!("{}: no calibration that can be used", path.display())));
        }
        records.push(("calibration", FactoryRecord::Calibration(calibration)));
    }
    if let Some(degrees) = args.toolface_offset {
        let mounting = Mounting { toolface_offset_rad: degrees.to_radians() };
        if !mounting.is_valid() {
            return Err(Failure::BadInput("--toolface-offset must be within a whole turn".to_owned()));
        }
        records.push(("mounting", FactoryRecord::Mounting(mounting)));
    }
    if let Some(path) = &args.key {
        records.push(("key", FactoryRecord::Key(KeyFile::open(path)?.to_write())));
    }
    Ok(records)
}

/// Writes each record, compares it with what the probe then holds, and says so.
///
/// # Errors
/// 2 for bad usage and for a refusal, 3 for a port, a file or an answer that is not there.
pub fn run(args: &ProvisionArgs) -> anyhow::Result<()> {
    let records = records(args)?;
    let mut line = Line::open(&args.line)?;
    if !line.is_live() {
        return Err(Failure::BadInput(format!("{}: a capture takes no commands", args.line.place)).into());
    }
    let deadline = Duration::from_secs(args.deadline);
    // A probe that has just been switched on does not listen yet.
    let probe = heard(&mut line, deadline)?;
    writeln!(stdout(), "probe: {probe}")?;
    for (name, record) in records {
        let mut ask = |only_check| {
            let command = Command::Provision { record, only_check };
            let answer = send_counting(&mut line, &command, None, probe, deadline)?;
            match answer.map_err(|counters| no_answer(deadline, &counters))? {
                Outcome::Accepted => Ok(()),
                Outcome::Refused(CommandRefusal::NothingThere) => {
                    Err(Failure::BadInput(format!("{name}: the probe holds none")).into())
                }
                Outcome::Refused(reason) => {
                    Err(Failure::BadInput(format!("{name}: the probe refused: {reason}")).into())
                }
                _ => Err(anyhow::Error::from(Failure::BadInput(format!("{name}: an answer of another version")))),
            }
        };
        if !args.check {
            ask(false)?;
        }
        ask(true)?;
        let done = if args.check { "as given" } else { "written and read back" };
        writeln!(stdout(), "{name}: {done}")?;
    }
    Ok(())
}
