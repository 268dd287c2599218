//! `mwd` without a command: the main job, end to end on a bundled recording.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use anyhow::Context;
use clap::Args;
use meerkat_mwd::{
    Config,
    compensation::GyroModel,
    identification::{Decision, WindowReport},
};

use crate::{
    commands::same_file::none_overwritten,
    diagnosis::diagnosed,
    layout::{Layout, named},
    report::{
        html::{Told, replay::page, write_page},
        picture::picture,
        plain_words,
        refusal_text::refusal_text,
    },
    target::{
        emulate::{EmulatedFlight, Feed, fly_emulated},
        error::EmulateError,
    },
};
use testbed::{
    console,
    failure::Failure,
    flight::{
        Flight,
        configuration::{freeze_at_us, of_trace},
        fly_frozen, started, watched,
    },
    score::{self, PerModel, Reference},
    simulate::known_error,
    trace::{Trace, recordings::folder},
};

/// Options of the main job.
#[derive(Debug, Clone, Default, Args)]
pub struct MainJobArgs {
    /// Write the rotation errors of flight 2 as a picture
    #[arg(long, value_name = "OUT.svg")]
    pub plot: Option<PathBuf>,
    /// Where to write the report of flight 2; mwd-report.html if not said
    #[arg(long, value_name = "OUT.html")]
    pub html: Option<PathBuf>,
    /// Print P and b with their deviations, all scores, and the cost on the chip
    #[arg(long)]
    pub details: bool,
}

/// A real recording: BROAD trial 06, cut to 110 s (attribution in the folder's README).
const RECORDING: &str = "broad_06_fast_rotation_110s.csv.gz";

/// Share of the recording held out for the scores.
const HOLD_OUT: f64 = 0.5;

/// Seed of the known error that is multiplied into the gyro for flights 2 and 3.
const KNOWN_ERROR_SEED: u64 = 1;

/// Number of the flight, share of the known error, and its size in words.
const KNOWN_ERRORS: [(u32, f64, &str); 2] = [
    (2, 1.0, "P diagonal up to 10 %, off-diagonal up to 5 %, bias 2 deg/s"),
    (3, 0.2, "P diagonal up to 2 %, off-diagonal up to 1 %, bias 0.4 deg/s"),
];

/// The report, where nobody names a file.
const UNNAMED_REPORT: &str = "mwd-report.html";

/// Number of the flight that `--plot` draws.
const DRAWN: u32 = 2;

/// Path of the main job's recording.
#[must_use]
pub fn recording() -> PathBuf {
    folder().join(RECORDING)
}

/// Flies the bundled recording as recorded and with a known error of two sizes, prints what was wrong, what was done
/// and what it gained, and writes the report of flight 2. Flies on the emulated chip; where no emulator can be had, on
/// this machine, and says so.
///
/// # Errors
/// The recording or the emulator fails, or a file cannot be written.
pub fn run(args: &MainJobArgs) -> anyhow::Result<()> {
    let report = args.html.clone().unwrap_or_else(|| UNNAMED_REPORT.into());
    let outputs: Vec<&Path> = args.plot.as_deref().into_iter().chain([report.as_path()]).collect();
    none_overwritten(&outputs, &[&recording()])?;
    let mut out = console::told();
    let trace = Trace::read(&recording())?;
    let config = of_trace(&trace);
    writeln!(
        out,
        "meerkat-mwd on a real recording: BROAD trial 06, fast rotation by hand, {} samples, {:.0} s at {:.0} Hz.",
        trace.samples.len(),
        trace.duration_s(),
        1e6 / f64::from(trace.nominal_period_us())
    )?;
    writeln!(
        out,
        "Identified on the first half; every score is over the second half, which identification never sees."
    )?;

    let as_recorded = flown(&config, &trace)?;
    writeln!(out, "{}\n", as_recorded.place)?;
    if !args.details && Layout::of_told() == Layout::Table {
        writeln!(out, "{HEAD}Rotation over 2 s, deg wrong (rms)      raw gyro  bias alone    as flown{HEAD:#}")?;
    }
    let title = "AS RECORDED (a factory-calibrated gyro, P within 0.7 % of the identity)";
    told(&mut out, args, (1, title, "as recorded"), &config, &trace, (&as_recorded.flight, None))?;

    let whole = known_error::draw(KNOWN_ERROR_SEED);
    let mut emulated = as_recorded.emulated;
    let (mut words, mut report_line) = (String::new(), String::new());
    for (number, scale, sizes) in KNOWN_ERRORS {
        let mut with_error = trace.clone();
        let truth = known_error::scaled(&whole, scale);
        known_error::apply(&mut with_error, &truth);
        let identified = flown(&config, &with_error)?;
        let title = format!("WITH A KNOWN ERROR multiplied in: {sizes}");
        let short = format!("with a known error of {:.0} %", 10.0 * scale);
        let flight = &identified.flight;
        if args.details {
            writeln!(out)?;
        }
        told(&mut out, args, (number, &title, &short), &config, &with_error, (flight, Some(&truth)))?;
        if number == DRAWN {
            words = sentences(&config, &with_error, flight);
            report_line = write_report(args, &config, &with_error, flight)?;
            if let Some(path) = &args.plot {
                draw(path, &config, &with_error, flight)?;
            }
        }
        emulated = identified.emulated;
    }

    writeln!(out)?;
    if args.details {
        for line in emulated.iter().flat_map(EmulatedFlight::cost_lines) {
            writeln!(out, "{line}")?;
        }
        writeln!(out)?;
    }
    writeln!(out, "{words}")?;
    writeln!(out, "Report of flight {DRAWN}: {HEAD}{report_line}{HEAD:#}")?;
    writeln!(
        out,
        "Next: `cargo mwd replay TRACE --html OUT.html` flies a recording of yours, a CSV file with the columns"
    )?;
    writeln!(
        out,
        "t_s gx gy gz ax ay az mx my mz; `cargo mwd --details` prints P and b, all scores and the cost on the chip."
    )?;
    Ok(())
}

/// Style of what stands out on a terminal.
const HEAD: anstyle::Style = anstyle::Style::new().bold();

/// Tells of a flight: in a line, or with all its figures.
fn told(
    out: &mut impl Write,
    args: &MainJobArgs,
    (number, title, short): (u32, &str, &str),
    config: &Config,
    trace: &Trace,
    (flight, truth): (&Flight, Option<&GyroModel>),
) -> io::Result<()> {
    if args.details {
        writeln!(out, "{HEAD}{number}. {title}{HEAD:#}")?;
        report(out, flight, truth)?;
        return scores(out, trace, flight);
    }
    let scored = score::score(trace, flight, &score::Settings::of(trace, config, flight));
    let cells = scored.map(|reference| {
        let PerModel { uncompensated, bias_only, with_effects, .. } = reference.orientation_2s_rms_time_aligned_deg;
        [uncompensated, bias_only, with_effects].map(|x| x.map_or_else(|| "none".to_owned(), |x| format!("{x:.2}")))
    });
    let cells = cells.unwrap_or_default();
    if Layout::of_told() == Layout::Lines {
        let told = named(["raw gyro", "bias alone", "as flown"], &cells);
        return writeln!(out, "flight {number}, {short}: rotation over 2 s, deg wrong (rms): {told}");
    }
    let [raw, bias, flown] = cells;
    writeln!(out, "  flight {number}, {short:<28} {raw:>8}    {bias:>8}    {HEAD}{flown:>8}{HEAD:#}")
}

/// Text on what was wrong with the gyro, what was done about it and what that gained: a sentence each.
fn sentences(config: &Config, trace: &Trace, flight: &Flight) -> String {
    let diagnosed = diagnosed(trace, config, flight);
    let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight));
    let gained = plain_words::gain(&diagnosed, reference.as_ref());
    format!(
        "In flight {DRAWN}, what was wrong: {}\nWhat was done: {}\nWhat it gained: {}\n",
        plain_words::gyro(config, flight),
        plain_words::done(trace, config, flight, &diagnosed),
        gained.unwrap_or_else(|| "nothing that can be told without a reference.".to_owned()),
    )
}

/// Writes the report of a flight as a page, and tells where it is. Where nobody named a file, one that cannot be
/// written does not end the job.
fn write_report(args: &MainJobArgs, config: &Config, trace: &Trace, flight: &Flight) -> anyhow::Result<String> {
    let diagnosed = diagnosed(trace, config, flight);
    let reference = score::score(trace, flight, &score::Settings::of(trace, config, flight));
    let watched = watched(started(config, flight.frozen_at_us, None)?, trace)?;
    let told = Told {
        trace,
        config,
        flight,
        diagnosed: &diagnosed,
        reference: reference.as_ref(),
        watched: Some(&watched),
        place: "with a known error of 10 % multiplied into the gyro's readings",
    };
    let path = args.html.as_deref().unwrap_or_else(|| Path::new(UNNAMED_REPORT));
    match write_page(path, &page(&told)) {
        Err(error) if args.html.is_none() => Ok(format!("none, {error}; name another place with --html")),
        written => Ok(written.map(|()| format!("{} (open it in a browser)", path.display()))?),
    }
}

/// Draws a flight's rotation errors over the half that is held out.
fn draw(path: &Path, config: &Config, trace: &Trace, flight: &Flight) -> anyhow::Result<()> {
    let drawn = picture(trace, flight, &score::Settings::of(trace, config, flight));
    let drawn = drawn.context("the recording has no reference to draw errors against")?;
    console::save(path, &drawn).map_err(|error| Failure::output(path, &error))?;
    Ok(())
}

/// A flight, and where it was flown.
struct Flown {
    flight: Flight,
    emulated: Option<EmulatedFlight>,
    place: String,
}

/// Flies with the second half held out.
fn flown(config: &Config, trace: &Trace) -> anyhow::Result<Flown> {
    let freeze_us = freeze_at_us(trace, HOLD_OUT);
    match fly_emulated(config, Some(freeze_us), &trace.samples, Feed::Direct) {
        Ok(emulated) => {
            let mut flight = emulated.flight.clone();
            flight.completed_by(fly_frozen(config, freeze_us, &trace.samples)?);
            let place = "Flown by the firmware on the emulated Cortex-M4F (STM32F405, QEMU).".to_owned();
            Ok(Flown { flight, emulated: Some(emulated), place })
        }
        Err(EmulateError::Missing(missing)) => Ok(Flown {
            flight: fly_frozen(config, freeze_us, &trace.samples)?,
            emulated: None,
            place: format!("Flown ON THIS MACHINE, by the same code: there is no emulator here. {missing}"),
        }),
        Err(error) => Err(error.into()),
    }
}

/// Prints the last accepted window, else the last one: accepted or refused and why, and P and b with their
/// sigmas.
fn report(out: &mut impl Write, flight: &Flight, truth: Option<&GyroModel>) -> io::Result<()> {
    let Some(window) = flight.standing().or(flight.reports.last()) else {
        return writeln!(out, "   no window was closed");
    };
    let verdict = match window.decision {
        Decision::Accepted => "ACCEPTED: P and b fly".to_owned(),
        Decision::Refused(refusal) => format!("REFUSED: {}", refusal_text(&refusal)),
        _ => "unknown decision".to_owned(),
    };
    writeln!(out, "   {verdict}")?;
    let seconds = |t_us: u64| t_us as f64 * 1e-6;
    let [matrix, hard_iron, accelerometer, turn, bias] = window.widths;
    writeln!(
        out,
        "   window {:.0} to {:.0} s; {:.1} s of motion since the start decide {} of 9 directions of P; squared innovations {:.2} of \
         what is expected",
        seconds(window.t_start_us),
        seconds(window.t_end_us),
        window.motion_s,
        window.directions_decided,
        window.innovation_nis,
    )?;
    writeln!(
        out,
        "   widths of the vector sensors' errors, times the data sheet's: magnetometer matrix {matrix:.2} and \
         misalignment {turn:.2}, hard iron {hard_iron:.2}, accelerometer matrix {accelerometer:.2} and bias {bias:.2}"
    )?;
    writeln!(out, "   a whole turn changes by {:.2} deg; {}", window.deg_per_turn, search(window))?;
    let sigma = |i: usize| window.sigma.get(i).copied().unwrap_or(f32::NAN);
    for (i, row) in window.fitted.p.iter().enumerate() {
        write!(out, "   P")?;
        for (j, p) in row.iter().enumerate() {
            write!(out, " {p:8.4} +-{:.4}", sigma(3 * i + j))?;
        }
        let b = window.fitted.b_rad_s.get(i).map_or(f32::NAN, |b| b.to_degrees());
        write!(out, "   b {b:6.3} +-{:.3} deg/s", sigma(9 + i).to_degrees())?;
        if let Some(truth) = truth {
            write!(out, "   known")?;
            for p in truth.p.get(i).into_iter().flatten() {
                write!(out, " {p:7.4}")?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Cost of the population search, and what it gained over the posterior mean.
fn search(window: &WindowReport) -> String {
    let cost = |x: Option<f32>| x.map_or("none".to_owned(), |x| format!("{x:.1}"));
    let added = window.cost_gained_by_search.map_or("nothing".to_owned(), |gained| format!("{gained:.2} of it"));
    format!(
        "IMOA: {} evaluations, cost {} -> {}, the search added {added}",
        window.evaluations,
        cost(window.cost_before),
        cost(window.cost_after)
    )
}

fn scores(out: &mut impl Write, trace: &Trace, flight: &Flight) -> io::Result<()> {
    let settings = score::Settings { from_us: flight.frozen_at_us.unwrap_or(0), ..score::Settings::default() };
    let Some(reference) = score::score(trace, flight, &settings) else {
        return writeln!(out, "   no reference to score against");
    };
    let Reference { attitude_rms_deg, .. } = reference;
    let cell = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let row = |PerModel { uncompensated, bias_only, twelve_parameters, with_effects }: PerModel| {
        let [uncompensated, bias_only, twelve, flown] =
            [uncompensated, bias_only, twelve_parameters, with_effects].map(cell);
        format!("uncompensated {uncompensated}, bias only {bias_only}, twelve parameters {twelve}, FLOWN {flown}")
    };
    writeln!(
        out,
        "   rotation error over 2 s, deg rms of the smallest 98 %: {}",
        row(reference.orientation_2s_rms_deg)
    )?;
    if let Some(delay_ms) = reference.time_alignment_ms {
        let aligned = row(reference.orientation_2s_rms_time_aligned_deg);
        writeln!(
            out,
            "   one delay of the gyro behind the reference ({delay_ms:.1} ms) fitted to that half: {aligned}"
        )?;
    }
    writeln!(
        out,
        "   attitude error, deg rms: total {}, heading {}, inclination {}",
        cell(attitude_rms_deg.total),
        cell(attitude_rms_deg.heading),
        cell(attitude_rms_deg.inclination)
    )
}
