//! `mwd simulate`: simulates a scenario and writes its trace.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use clap::Args;

use super::same_file::none_overwritten;
use crate::report::picture;
use testbed::{
    console::{save, told},
    failure::Failure,
    progress_bar::progress_bar,
    simulate::{Scenario, describe, samples_of, simulate_with},
};

/// Options of `simulate`.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// The scenario, TOML; - reads the standard input
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Where to write the trace, .csv or .csv.gz; - writes plain text to the standard output
    #[arg(short, value_name = "TRACE.csv.gz")]
    pub output: Option<PathBuf>,
    /// Seed of the sensors' noise and of the motion
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Draw how the tool turns
    #[arg(long, value_name = "OUT.svg")]
    pub plot_rate: Option<PathBuf>,
    /// Draw what the gyro reads less the truth
    #[arg(long, value_name = "OUT.svg")]
    pub plot_error: Option<PathBuf>,
}

/// Reads a scenario, simulates it, writes the trace and prints the true gyro model.
///
/// Without `-o` the trace is written to the current directory under the scenario's name.
///
/// # Errors
/// The scenario cannot be read or used, or an output cannot be written or would overwrite the scenario or another one.
pub fn run(args: &SimulateArgs) -> anyhow::Result<()> {
    let name = args.scenario.file_stem().map_or_else(|| "simulated".into(), |stem| stem.to_string_lossy());
    let path = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{name}.csv.gz")));
    let drawn = [&args.plot_rate, &args.plot_error].into_iter().flatten();
    let outputs: Vec<&Path> = std::iter::once(&path).chain(drawn).map(AsRef::as_ref).collect();
    none_overwritten(&outputs, &[&args.scenario])?;
    let scenario = Scenario::read(&args.scenario)?;
    let seed = args.seed.unwrap_or(1);
    let bar = progress_bar(usize::try_from(samples_of(&scenario)).unwrap_or(usize::MAX));
    let (trace, truth) = simulate_with(&scenario, seed, |done| {
        if done % 1_000 == 0 {
            bar.set_position(done);
        }
    });
    bar.finish_and_clear();
    trace.write(&path)?;
    for (path, drawn) in [(&args.plot_rate, picture::rates(&trace)), (&args.plot_error, picture::gyro_errors(&trace))] {
        if let (Some(path), Some(drawn)) = (path, drawn) {
            save(path, &drawn).map_err(|error| Failure::output(path, &error))?;
        }
    }
    let mut out = told();
    writeln!(out, "{}: {} samples, {:.1} s, seed {seed}", path.display(), trace.samples.len(), trace.duration_s())?;
    writeln!(out, "true gyro model: {}", describe(&truth.gyro))?;
    writeln!(out, "shocks: {}", truth.shocks.len())?;
    writeln!(out, "Next: `cargo mwd replay {} --html report.html` flies it.", path.display())?;
    Ok(())
}
