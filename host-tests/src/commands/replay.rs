//! `mwd replay`: read, configure, fly on the host, score, deliver.

use std::{
    fs,
    io::{self, Write},
    path::PathBuf,
};

use clap::{Args, ValueEnum};
use meerkat_mwd::{Config, Probe, config::OptimizerKind, storage::StoredModel};

use super::{hold_out::hold_out, same_file::same_file};
use crate::{
    diagnosis::diagnosed,
    failure::Failure,
    flight::{
        Flight,
        configuration::{configuration, freeze_at_us},
        fly_on, started, surveys, through_sensors,
    },
    report::{
        attitude_csv::write_attitude_csv,
        explanation::{Explanation, print_explanation},
        html::{replay::page, write_page},
        json::result_json,
        progress_bar::progress_bar,
        rates_csv::write_rates_csv,
        summary::print_summary,
        surveys_csv::write_surveys_csv,
    },
    score::{self, Reference},
    trace::Trace,
};

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
    /// Sets what the command line names.
    fn set(&self, config: &mut Config, trace: &Trace) {
        if let Some(seed) = self.seed {
            config.seed = seed;
        }
        if let Some(optimizer) = self.optimizer {
            config.identification.optimizer = optimizer.kind();
        }
        if self.no_effects {
            config.effects = false;
        }
        if let Some(fraction) = self.hold_out {
            config.freeze_at_us = Some(freeze_at_us(trace, fraction));
        }
    }
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

/// Flies a trace on the host and delivers the summary and the files asked for.
///
/// # Errors
/// Bad input or usage; see [`crate::commands::exit_status::exit_status`].
pub fn run(args: &ReplayArgs) -> anyhow::Result<()> {
    let (mut trace, config) = prepare(args)?;
    let recorded = if args.through_sensors { through_sensors::each_field_once(&trace.samples) } else { Vec::new() };
    let played = args.through_sensors.then(|| through_sensors::play(&recorded, config.sample_period_us));
    if let Some(played) = &played {
        trace.samples.clone_from(&played.samples);
    }
    let flight = fly_with_bar(started(&config, stored_model(args)?.as_ref())?, &trace);
    deliver(args, &trace, &config, &flight, "on this machine")?;
    if let Some(played) = &played {
        through_sensors::report(&mut io::stdout().lock(), &config, &recorded, played)?;
    }
    Ok(())
}

/// Flies a trace on the host and shows how far it is.
#[must_use]
pub fn fly_with_bar(probe: Box<Probe>, trace: &Trace) -> Flight {
    let bar = progress_bar(trace.samples.len());
    let flight = fly_on(probe, &trace.samples, |flown| {
        // A thousand samples fly in well under a frame.
        if flown % 1_000 == 0 {
            bar.set_position(flown as u64);
        }
    });
    bar.finish_and_clear();
    flight
}

/// The stored model that the arguments name.
fn stored_model(args: &ReplayArgs) -> Result<Option<StoredModel>, Failure> {
    let Some(path) = &args.model else { return Ok(None) };
    let bad = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
    let text = fs::read_to_string(path).map_err(|e| bad(format!("cannot be read: {e}")))?;
    toml::from_str(&text).map(Some).map_err(|e| bad(e.to_string().trim_end().replace('\n', " ")))
}

/// Reads the trace and makes its configuration; everything that can be wrong with the arguments shows here.
///
/// # Errors
/// Bad input or usage.
pub fn prepare(args: &ReplayArgs) -> anyhow::Result<(Trace, Config)> {
    check_outputs(args)?;
    let mut trace = Trace::read(&args.trace)?;
    let config = configuration(&trace, args.config.as_deref(), |config| args.set(config, &trace))?;
    trace.mark_clipped(&config.full_scale);
    Ok((trace, config))
}

/// No result may overwrite what is read, nor another result.
fn check_outputs(args: &ReplayArgs) -> Result<(), Failure> {
    let outputs = [&args.attitude, &args.rates, &args.surveys, &args.json, &args.html];
    for (index, output) in outputs.into_iter().enumerate() {
        // A terminal or /dev/null takes any number of them.
        let Some(output) = output.as_ref().filter(|output| !output.exists() || output.is_file()) else { continue };
        let taken =
            |what: &str| Err(Failure::BadInput(format!("{}: the result would overwrite {what}", output.display())));
        if same_file(output, &args.trace) {
            return taken("the trace");
        }
        if [&args.config, &args.model].into_iter().flatten().any(|read| same_file(output, read)) {
            return taken("the configuration");
        }
        if outputs.into_iter().take(index).flatten().any(|other| other == output || same_file(output, other)) {
            return taken("another one");
        }
    }
    Ok(())
}

/// Scores a flight, prints the summary and writes the files asked for; the same for a flight on the host and on the
/// emulated chip. `place` says where it was flown, for the summary's first line.
///
/// # Errors
/// When a file or the summary cannot be written.
pub fn deliver(
    args: &ReplayArgs,
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    place: &str,
) -> anyhow::Result<Option<Reference>> {
    let reference = score::score(trace, flight, &score::Settings::of(trace, config));
    let diagnosed = diagnosed(trace, config, flight);
    if let Some(path) = &args.attitude {
        write_attitude_csv(&flight.outputs, path)?;
    }
    if let Some(path) = &args.rates {
        write_rates_csv(&flight.outputs, path)?;
    }
    if let Some(path) = &args.surveys {
        let probe = started(config, stored_model(args)?.as_ref())?;
        write_surveys_csv(&surveys(probe, &trace.samples)?, path)?;
    }
    let explanation = if args.explain {
        Some(Explanation::of(started(config, stored_model(args)?.as_ref())?, trace, config, flight))
    } else {
        None
    };
    if let Some(path) = &args.json {
        let result = result_json(trace, config, flight, &diagnosed, reference);
        explanation.iter().fold(result, |result, explanation| result.explained(explanation)).write(path)?;
    }
    if let Some(path) = &args.html {
        write_page(path, &page(trace, config, flight, &diagnosed, reference.as_ref(), place))?;
    }
    let mut out = io::stdout().lock();
    writeln!(out, "flown {place}")?;
    print_summary(&mut out, trace, config, flight, &diagnosed, reference.as_ref())?;
    if let Some(explanation) = &explanation {
        print_explanation(&mut out, flight, explanation)?;
    }
    Ok(reference)
}
