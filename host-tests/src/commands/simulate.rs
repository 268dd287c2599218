//! `mwd simulate`: simulates a scenario and writes its trace.

use std::path::PathBuf;

use clap::Args;

use crate::simulate::{Scenario, describe, simulate};

/// Options of `simulate`.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// The scenario, TOML
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Where to write the trace, .csv or .csv.gz
    #[arg(short, value_name = "TRACE.csv.gz")]
    pub output: Option<PathBuf>,
    /// Seed of the sensors' noise and of the motion
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Reads a scenario, simulates it, writes the trace and prints the true gyro model.
///
/// Without `-o` the trace is written to the current directory under the scenario's name.
///
/// # Errors
/// The scenario cannot be read or used, or the trace cannot be written.
pub fn run(args: &SimulateArgs) -> anyhow::Result<()> {
    let scenario = Scenario::read(&args.scenario)?;
    let name = args.scenario.file_stem().map_or_else(|| "simulated".into(), |stem| stem.to_string_lossy());
    let path = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.csv.gz")));
    let seed = args.seed.unwrap_or(1);
    let (trace, truth) = simulate(&scenario, seed);
    trace.write(&path)?;
    println!("{}: {} samples, {:.1} s, seed {seed}", path.display(), trace.samples.len(), trace.duration_s());
    println!("true gyro model: {}", describe(&truth.gyro));
    println!("shocks: {}", truth.shocks.len());
    println!("Next: `cargo mwd replay {} --html report.html` flies it.", path.display());
    Ok(())
}
