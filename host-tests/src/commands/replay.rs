//! `mwd replay`: reads a trace, configures and flies the pipeline on this machine, scores and delivers.

use std::{
    io::Write,
    path::{Path, PathBuf},
};

use clap::{Args, ValueEnum};
use meerkat_mwd::{Config, Probe, config::OptimizerKind, storage::StoredModel};

use super::{hold_out::hold_out, next_step::after_flight, same_file::same_file, toml_file};
use crate::{
    diagnosis::diagnosed,
    import::plausible::checked,
    layout::Layout,
    report::{
        attitude_csv::write_attitude_csv,
        dynamics_csv::{write_burst_csv, write_dynamics_csv},
        explanation::{Explanation, print_explanation},
        flight_notes::add_flight_notes,
        html::{Told, replay::page, write_page},
        json::result_json,
        plain_words,
        rates_csv::write_rates_csv,
        summary::print_summary,
        surveys_csv::write_surveys_csv,
    },
};
use testbed::{
    console::told,
    failure::Failure,
    flight::{
        Flight,
        configuration::{configuration, frozen_from_us},
        dynamics, fly_on, started, surveys, through_sensors, watched, worst_second,
    },
    progress_bar::progress_bar,
    score::{self, Reference},
    trace::{Trace, TraceError},
};

/// Style of what stands out on a terminal.
pub const HEAD: anstyle::Style = anstyle::Style::new().bold();

/// Options of `replay` and `emulate`.
#[derive(Debug, Clone, Args)]
pub struct ReplayArgs {
    /// The trace, .csv or .csv.gz; - reads the standard input. Of the outputs, - is the standard output
    pub trace: PathBuf,
    /// Write the attitude of every sample
    #[arg(long, help_heading = "Files to write", value_name = "OUT.csv")]
    pub attitude: Option<PathBuf>,
    /// Write the compensated rate of every sample
    #[arg(long, help_heading = "Files to write", value_name = "OUT.csv")]
    pub rates: Option<PathBuf>,
    /// Write the surveys taken at rest and while rotating
    #[arg(long, help_heading = "Files to write", value_name = "OUT.csv")]
    pub surveys: Option<PathBuf>,
    /// Write vibration, shocks, stick-slip and whirl of every 30 s, with their severity
    #[arg(long, help_heading = "Files to write", value_name = "OUT.csv")]
    pub dynamics: Option<PathBuf>,
    /// Write the raw samples of the second that shook most
    #[arg(long, help_heading = "Files to write", value_name = "OUT.csv")]
    pub burst: Option<PathBuf>,
    /// Write the result as JSON
    #[arg(long, help_heading = "Files to write", value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write a report with figures as HTML
    #[arg(long, help_heading = "Files to write", value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Hold out the last fraction F of the trace: freeze the parameters before it and score only there
    #[arg(long, help_heading = "Model and search", value_name = "F", value_parser = hold_out)]
    pub hold_out: Option<f64>,
    /// Configuration that overrides the trace's header
    #[arg(long, help_heading = "Model and search", value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Start with this stored model, as written by `record`, instead of the factory's
    #[arg(long, help_heading = "Model and search", value_name = "FILE.toml")]
    pub model: Option<PathBuf>,
    /// Search method for the parameters
    #[arg(long, help_heading = "Model and search")]
    pub optimizer: Option<Optimizer>,
    /// Seed of the search
    #[arg(long, help_heading = "Model and search", value_name = "N")]
    pub seed: Option<u64>,
    /// Identify the 12 parameters only and look for no further effect
    #[arg(long, help_heading = "Model and search")]
    pub no_effects: bool,
    /// Explain each window after the summary: the evidence, which sensor is to blame, what moved P, and how
    /// far P is from a known one
    #[arg(long, help_heading = "Explanation and refusals")]
    pub explain: bool,
    /// Pass the samples through register models of an ISM330DHCX and an RM3100 and their adapters, as
    /// `emulate` does
    #[arg(long, help_heading = "Model and search")]
    pub through_sensors: bool,
    /// Refuse a trace with a row whose time repeats or goes back, instead of dropping that row
    #[arg(long, help_heading = "Explanation and refusals")]
    pub strict: bool,
    /// Fly a trace whose units, signs or axes cannot be; nothing is identified from it
    #[arg(long, help_heading = "Explanation and refusals")]
    pub force: bool,
}

impl ReplayArgs {
    /// Sets the fields that the command line names.
    fn set(&self, config: &mut Config) {
        if let Some(seed) = self.seed {
            config.seed = seed;
        }
        if let Some(optimizer) = self.optimizer {
            config.identification.optimizer = optimizer.kind();
        }
        if self.no_effects {
            config.effects = false;
        }
    }
}

/// Values of `--optimizer`.
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
    /// Closed-form least squares
    Ls,
}

impl Optimizer {
    /// The library's name for this search.
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

/// Flies a trace on this machine, prints the summary and writes the files asked for.
///
/// # Errors
/// Bad input or usage; see [`crate::commands::exit_status::exit_status`].
pub fn run(args: &ReplayArgs) -> anyhow::Result<()> {
    // Options that go through the trace more than forwards need it in memory.
    let is_in_memory = args.through_sensors || args.explain || args.html.is_some();
    let (mut trace, config) = prepare(args, if is_in_memory { Trace::read } else { Trace::spooled })?;
    let recorded = if args.through_sensors { through_sensors::each_field_once(&trace.samples) } else { Vec::new() };
    let played = args.through_sensors.then(|| through_sensors::play(&recorded, config.sample_period_us));
    if let Some(played) = &played {
        trace.samples.clone_from(&played.samples);
    }
    let freeze_at_us = frozen_from_us(&trace, args.hold_out, args.config.as_deref())?;
    let flight = fly_with_bar(started(&config, freeze_at_us, stored_model(args)?.as_ref())?, &trace);
    add_flight_notes(&mut trace, &config, &flight);
    deliver(args, &trace, &config, &flight, "on this machine")?;
    if let Some(played) = &played {
        through_sensors::report(&mut told(), &config, &recorded, played)?;
    }
    writeln!(told(), "next     {}", after_flight(&flight, args.html.as_deref()))?;
    Ok(())
}

/// Flies a trace on this machine with a progress bar.
#[must_use]
pub fn fly_with_bar(probe: Box<Probe>, trace: &Trace) -> Flight {
    let bar = progress_bar(trace.len());
    let flight = fly_on(probe, trace, |flown| {
        // A thousand samples take well under a frame of the bar.
        if flown % 1_000 == 0 {
            bar.set_position(flown as u64);
        }
    });
    bar.finish_and_clear();
    flight
}

/// Reads the stored model of `--model`.
fn stored_model(args: &ReplayArgs) -> Result<Option<StoredModel>, Failure> {
    args.model.as_deref().map(toml_file::read).transpose()
}

/// Reads the trace by `read` and makes its configuration; reports every error that the arguments can have.
///
/// # Errors
/// Bad input or usage.
pub fn prepare(
    args: &ReplayArgs,
    read: impl FnOnce(&Path) -> Result<Trace, TraceError>,
) -> anyhow::Result<(Trace, Config)> {
    check_outputs(args)?;
    let mut trace = read(&args.trace)?;
    if args.strict {
        trace.none_dropped()?;
    }
    let mut config = configuration(&trace, args.config.as_deref(), |config| args.set(config))?;
    trace.mark_clipped(&config.full_scale);
    checked(&mut trace, &mut config, args.force)?;
    Ok((trace, config))
}

/// Refuses to overwrite an input, and to write two results to one file.
fn check_outputs(args: &ReplayArgs) -> Result<(), Failure> {
    let outputs = [&args.attitude, &args.rates, &args.surveys, &args.dynamics, &args.burst, &args.json, &args.html];
    for (index, output) in outputs.into_iter().enumerate() {
        // A terminal or /dev/null may be named any number of times.
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

/// Scores a flight, prints the summary and writes the files asked for; used for flights on this machine and
/// on the emulated chip. `place` tells the summary where it was flown.
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
    let probe = || started(config, flight.frozen_at_us, stored_model(args)?.as_ref());
    let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight));
    let diagnosed = diagnosed(trace, config, flight);
    if let Some(path) = &args.attitude {
        write_attitude_csv(flight.rows(), path)?;
    }
    if let Some(path) = &args.rates {
        write_rates_csv(flight.rows(), path)?;
    }
    let taken = if args.surveys.is_some() || args.json.is_some() {
        let mut taken = surveys(probe()?, trace)?;
        taken.iter_mut().for_each(|report| trace.grade(report));
        taken
    } else {
        Vec::new()
    };
    if let Some(path) = &args.surveys {
        write_surveys_csv(&taken, path)?;
    }
    if let Some(path) = &args.dynamics {
        write_dynamics_csv(&dynamics(probe()?, trace)?, config.survey.dynamics.shock_m_s2, path)?;
    }
    if let Some(path) = &args.burst {
        write_burst_csv(&worst_second(probe()?, trace), path)?;
    }
    let explanation = if args.explain { Some(Explanation::of(probe()?, trace, config, flight)) } else { None };
    if let Some(path) = &args.json {
        let result = result_json(trace, config, flight, &diagnosed, reference).with_surveys(&taken);
        explanation.iter().fold(result, |result, explanation| result.explained(explanation)).write(path)?;
    }
    if let Some(path) = &args.html {
        let watched = watched(probe()?, trace)?;
        let (diagnosed, reference) = (&diagnosed, reference.as_ref());
        write_page(path, &page(&Told { trace, config, flight, diagnosed, reference, watched: Some(&watched), place }))?;
    }
    trace.all_read()?;
    flight.all_read()?;
    let mut out = told();
    let verdict = plain_words::verdict(trace, config, flight, &diagnosed);
    writeln!(out, "{HEAD}verdict  {}{HEAD:#}", verdict.sentence)?;
    writeln!(out, "flown {place}")?;
    print_summary(&mut out, Layout::of_told(), trace, config, flight, &diagnosed, reference.as_ref())?;
    if let Some(explanation) = &explanation {
        print_explanation(&mut out, flight, explanation)?;
    }
    Ok(reference)
}
