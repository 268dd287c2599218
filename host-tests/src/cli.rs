//! The command line.

use std::{io, path::PathBuf, process::ExitCode};

use clap::{Args, Parser, Subcommand, ValueEnum};
use meerkat_mwd::config::OptimizerKind;
use world_magnetic_model::time::Date;

use crate::{
    bench, calibrate, command, diagnose, emulate,
    failure::{Failure, exit_status},
    main_job, monitor, record, reference_field, replay, simulate,
};

/// Identifies gyro errors while drilling and streams attitude: replays, emulates, simulates and scores. Without a
/// subcommand: the main job, end to end on the bundled recording.
#[derive(Debug, Parser)]
#[command(name = "mwd", bin_name = "cargo mwd", version)]
pub struct Cli {
    /// What to do; the main job when absent.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a trace on this machine: parameters or a reasoned refusal, attitude, scores
    Replay(ReplayArgs),
    /// Tell which physical effect the residual shows
    Diagnose(DiagnoseArgs),
    /// Fly a trace by the firmware on the emulated Cortex-M4F, through register-level models of its sensors and their adapters
    Emulate(emulate::EmulateArgs),
    /// Accelerometer and magnetometer models from rests and turns
    Calibrate(CalibrateArgs),
    /// Write the trace of a scenario
    Simulate(SimulateArgs),
    /// Measure speed and accuracy
    Bench(BenchArgs),
    /// Write what a probe sends of its raw samples as a trace, and its configuration beside it
    Record(record::RecordArgs),
    /// Show what a probe says
    Monitor(monitor::MonitorArgs),
    /// Send a command to a probe and wait for its answer
    Command(command::CommandArgs),
    /// The reference field and gravity of a place, as a configuration
    Field(FieldArgs),
}

/// Options of `replay` and `emulate`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArgs {
    /// The trace, .csv or .csv.gz
    pub trace: PathBuf,
    /// Write the attitude of every sample
    #[arg(long, value_name = "OUT.csv")]
    pub attitude: Option<PathBuf>,
    /// Write the compensated rate of every sample
    #[arg(long, value_name = "OUT.csv")]
    pub rates: Option<PathBuf>,
    /// Write the surveys taken at rest and while rotating
    #[arg(long, value_name = "OUT.csv")]
    pub surveys: Option<PathBuf>,
    /// Write the result
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Score the last fraction F of the trace, with parameters frozen before it
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
    /// Configuration on top of what the trace says
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// A stored model that flies from the first sample on, as `record` writes it
    #[arg(long, value_name = "FILE.toml")]
    pub model: Option<PathBuf>,
    /// What searches for the parameters
    #[arg(long)]
    pub optimizer: Option<Optimizer>,
    /// Seed of the search
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Look for no effect beyond the 12 parameters
    #[arg(long)]
    pub no_effects: bool,
    /// Through register-level models of an ISM330DHCX and an RM3100 and the adapters for them, as `emulate` does
    #[arg(long)]
    pub through_sensors: bool,
}

impl ReplayArgs {
    /// The replay that a diagnosis looks at.
    #[must_use]
    pub fn of_diagnose(args: &DiagnoseArgs) -> Self {
        Self {
            trace: args.trace.clone(),
            attitude: None,
            rates: None,
            surveys: None,
            json: args.json.clone(),
            html: None,
            hold_out: args.hold_out,
            config: args.config.clone(),
            model: None,
            optimizer: None,
            seed: None,
            no_effects: false,
            through_sensors: false,
        }
    }

    /// # Errors
    /// The first option that is named and not built yet.
    pub const fn check_built(&self) -> Result<(), Failure> {
        if self.html.is_some() { Err(Failure::NotBuilt("--html")) } else { Ok(()) }
    }
}

/// Options of `diagnose`.
#[derive(Debug, Clone, Args)]
pub struct DiagnoseArgs {
    /// The trace, .csv or .csv.gz
    pub trace: PathBuf,
    /// Use the reference columns, as on a bench with an external truth
    #[arg(long)]
    pub against_reference: bool,
    /// Score the last fraction F of the trace
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
    /// Configuration on top of what the trace says
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Write the result
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
}

/// Options of `calibrate`.
#[derive(Debug, Clone, Args)]
pub struct CalibrateArgs {
    /// Traces of one probe, .csv or .csv.gz
    #[arg(required = true, value_name = "TRACE")]
    pub traces: Vec<PathBuf>,
    /// Where to write the models, for --config
    #[arg(short, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Write the result
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Configuration on top of what the traces say; its models of the sensors are the old values
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Do not calibrate on the last fraction F of each trace, only check there
    #[arg(long, value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
}

/// Options of `simulate`.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// The scenario
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Where to write the trace, .csv or .csv.gz
    #[arg(short, value_name = "TRACE.csv.gz")]
    pub output: Option<PathBuf>,
    /// Seed of the sensors' noise and of the motion
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Options of `bench`.
#[derive(Debug, Clone, Args)]
pub struct BenchArgs {
    /// Fewer repetitions
    #[arg(long)]
    pub quick: bool,
    /// So many repetitions of everything
    #[arg(long, value_name = "N", conflicts_with = "quick", value_parser = clap::value_parser!(u64).range(1..))]
    pub seeds: Option<u64>,
    /// On the emulated chip, and nothing else
    #[arg(long)]
    pub target: bool,
    /// Only this section; may be given more than once
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write the figures
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
}

/// Options of `field`.
#[derive(Debug, Clone, Args)]
pub struct FieldArgs {
    /// Geodetic latitude, degrees north
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub latitude: f64,
    /// Longitude, degrees east
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub longitude: f64,
    /// Height above the WGS 84 ellipsoid, metres
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.0)]
    pub altitude: f64,
    /// Day, 2020 to 2029
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = reference_field::day)]
    pub date: Date,
}

/// Names of `--optimizer`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Optimizer {
    /// Improved meerkat optimisation algorithm
    Imoa,
    /// Meerkat optimisation algorithm
    Moa,
    /// Particle swarm
    Pso,
    /// Differential evolution
    De,
    /// Levenberg-Marquardt
    Lm,
    /// The closed-form least-squares point
    Ls,
}

impl Optimizer {
    /// What the library calls it.
    #[must_use]
    pub const fn kind(self) -> OptimizerKind {
        match self {
            Self::Imoa => OptimizerKind::Imoa,
            Self::Moa => OptimizerKind::Moa,
            Self::Pso => OptimizerKind::Pso,
            Self::De => OptimizerKind::De,
            Self::Lm => OptimizerKind::Lm,
            Self::Ls => OptimizerKind::Ls,
        }
    }
}

fn hold_out(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(fraction) if fraction > 0.0 && fraction < 1.0 => Ok(fraction),
        _ => Err("must be a number between 0 and 1, both excluded".to_owned()),
    }
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let Err(error) = dispatch(Cli::parse().command) else {
        return ExitCode::SUCCESS;
    };
    // Whoever reads the output has seen enough.
    if error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
    {
        return ExitCode::SUCCESS;
    }
    eprintln!("error: {}", told_once(&error));
    ExitCode::from(exit_status(&error))
}

/// The chain of an error, without the causes whose text the one above has already taken in.
fn told_once(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |told, cause| {
        if told.is_empty() {
            cause
        } else if told.contains(cause.trim_end()) {
            told
        } else {
            format!("{told}: {cause}")
        }
    })
}

fn dispatch(command: Option<Command>) -> anyhow::Result<()> {
    match command {
        None => main_job::run(),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Emulate(args)) if args.replay.model.is_some() => {
            Err(Failure::BadInput("--model: the emulated chip starts with the factory's model".to_owned()).into())
        }
        Some(Command::Emulate(args)) => emulate::run(&args),
        Some(Command::Simulate(args)) => simulate::run(&args),
        Some(Command::Diagnose(args)) => diagnose::run(&args),
        Some(Command::Calibrate(args)) => calibrate::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Record(args)) => record::run(&args),
        Some(Command::Monitor(args)) => monitor::run(&args),
        Some(Command::Command(args)) => command::run(&args),
        Some(Command::Field(args)) => reference_field::run(&args),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn a_cause_is_told_once() {
        let scenario = simulate::Scenario::read(&PathBuf::from("none.toml")).map_err(anyhow::Error::from);
        let told = scenario.map_or_else(|error| told_once(&error), |_| String::new());
        assert!(told.starts_with("none.toml: ") && told.matches("os error").count() == 1, "{told}");
        assert_eq!(told_once(&anyhow::anyhow!("inner").context("outer")), "outer: inner");
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
