//! `mwd replay`: read, configure, fly on the host, score, deliver.

mod html;

use std::{
    fs,
    io::{self, IsTerminal, Write},
};

use indicatif::{ProgressBar, ProgressStyle};
use meerkat_mwd::{Config, Probe, storage::StoredModel};

use crate::{
    attitude_csv::write_attitude_csv,
    cli::ReplayArgs,
    configuration::configuration,
    diagnose::diagnosed,
    explain::{Explanation, print_explanation},
    failure::Failure,
    flight::{Flight, fly_on, started, surveys},
    page::write_page,
    rates_csv::write_rates_csv,
    result_json::result_json,
    same_file::same_file,
    score::{self, Reference},
    summary::print_summary,
    surveys_csv::write_surveys_csv,
    through_sensors,
    trace::Trace,
};

/// Flies a trace on the host and delivers the summary and the files asked for.
///
/// # Errors
/// Bad input or usage; see [`crate::failure::exit_status`].
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
    let config = configuration(&trace, args)?;
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
    let reference = score::score(trace, flight, &settings(trace, config));
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
        write_page(path, &html::page(trace, config, flight, &diagnosed, reference.as_ref(), place))?;
    }
    let mut out = io::stdout().lock();
    writeln!(out, "flown {place}")?;
    print_summary(&mut out, trace, config, flight, &diagnosed, reference.as_ref())?;
    if let Some(explanation) = &explanation {
        print_explanation(&mut out, flight, explanation)?;
    }
    Ok(reference)
}

/// What the scorer has to know of a flight over `trace`.
#[must_use]
pub fn settings(trace: &Trace, config: &Config) -> score::Settings {
    score::Settings {
        from_us: config.freeze_at_us.unwrap_or(trace.first_us()),
        accel: config.accel,
        factory: config.gyro,
        declination_deg: config.earth.declination_rad.map(|x| f64::from(x).to_degrees()),
    }
}

/// A bar on a terminal, nothing in a pipe.
#[must_use]
pub fn progress_bar(samples: usize) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta}").ok();
    let bar = ProgressBar::new(samples as u64);
    style.into_iter().fold(bar, ProgressBar::with_style)
}
