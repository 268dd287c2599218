//! The options of each command.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use meerkat_mwd::config::OptimizerKind;
use world_magnetic_model::time::Date;

use crate::reference_field;

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
    /// After the summary: what each window's report rests on, which sensor is to blame, what moved P, and how far P is from a known one
    #[arg(long)]
    pub explain: bool,
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
            html: args.html.clone(),
            hold_out: args.hold_out,
            config: args.config.clone(),
            model: None,
            optimizer: None,
            seed: None,
            no_effects: false,
            explain: false,
            through_sensors: false,
        }
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
