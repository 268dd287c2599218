//! The summary of a flight, one screen long.

use std::io::{self, Write};

use meerkat_mwd::{
    Config, SampleFlags,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};

use crate::{
    diagnosis::Diagnosed,
    layout::{Layout, named},
    number::fixed,
    report::{
        account::{sentences, verdict_name},
        attitude_at_end,
        json::parameters::Parameters,
        motion,
        refusal_text::decision_text,
        window_note::{why_no_window, window_note},
    },
};
use testbed::{
    flight::Flight,
    score::{PerModel, Reference},
    trace::{Trace, clipping_is_known, seconds},
};

/// Number of windows above which they are counted instead of listed.
const LISTED_WINDOWS: usize = 8;

/// Prints the attitude at the end, trace facts, notes, windows, final parameters and scores.
///
/// # Errors
/// When `out` takes no more.
pub fn print_summary(
    out: &mut impl Write,
    layout: Layout,
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    diagnosed: &Diagnosed,
    reference: Option<&Reference>,
) -> io::Result<()> {
    let [angles, totals] = attitude_at_end::lines(config, flight, &diagnosed.totals);
    writeln!(out, "attitude {angles}\n         {totals}")?;
    print_trace(out, trace, config, flight)?;
    print_windows(out, trace, config, flight)?;
    print_diagnosed(out, config, diagnosed)?;
    print_parameters(out, layout, &Parameters::at_the_end(config, flight))?;
    match reference {
        Some(reference) => print_scores(out, layout, flight, reference),
        None => writeln!(out, "scores   none: the trace holds nothing to score against"),
    }
}

fn print_trace(out: &mut impl Write, trace: &Trace, config: &Config, flight: &Flight) -> io::Result<()> {
    let (facts, period_us) = (trace.facts(), trace.nominal_period_us());
    write!(out, "trace    {}: {} samples, {:.2} s", trace.path.display(), trace.len(), trace.duration_s())?;
    if period_us > 0 {
        write!(out, " at {:.2} Hz", 1e6 / f64::from(period_us))?;
    }
    writeln!(out)?;
    let total = trace.len();
    let absent = |what: &str, missing: usize| match missing {
        0 => None,
        all if all == total => Some(format!("no {what}")),
        some => Some(format!("{some} samples without {what}")),
    };
    let clipped = if clipping_is_known(&config.full_scale) {
        format!("{} clipped samples", facts.clipped)
    } else {
        "clipping unknown (no full scale given)".to_owned()
    };
    let remarks = [
        Some(format!("{} gaps in time", facts.gaps)),
        Some(clipped),
        absent("gyro", facts.count(SampleFlags::GYRO_MISSING)),
        absent("accelerometer", facts.count(SampleFlags::ACCEL_MISSING)),
        absent("magnetometer", facts.count(SampleFlags::MAG_MISSING)),
        absent("temperature", facts.count(SampleFlags::TEMPERATURE_MISSING)),
        absent("reference", facts.without_reference()),
    ];
    writeln!(out, "         {}", remarks.into_iter().flatten().collect::<Vec<_>>().join("; "))?;
    for wrong in &trace.wrong {
        writeln!(out, "WRONG    {wrong}; nothing is identified from it, and no survey of it is good")?;
    }
    for note in &trace.notes {
        writeln!(out, "note     {note}")?;
    }
    writeln!(out, "{}", motion::line(trace, config))?;
    if let Some(freeze) = flight.frozen_at_us {
        writeln!(out, "hold-out parameters frozen from {} s; scores are over what follows", seconds(freeze))?;
    }
    Ok(())
}

fn print_windows(out: &mut impl Write, trace: &Trace, config: &Config, flight: &Flight) -> io::Result<()> {
    let accepted = flight.reports.iter().filter(|report| report.decision == Decision::Accepted).count();
    let count = flight.reports.len();
    match why_no_window(trace, config, flight) {
        Some(why) => writeln!(out, "windows  {why}")?,
        None => writeln!(out, "windows  {count}: {accepted} accepted, {} refused", count - accepted)?,
    }
    let hidden = count.saturating_sub(LISTED_WINDOWS);
    if hidden > 0 {
        writeln!(out, "         (the last {LISTED_WINDOWS} follow)")?;
    }
    flight.reports.iter().skip(hidden).try_for_each(|report| print_window(out, config, report))
}

fn print_window(out: &mut impl Write, config: &Config, report: &WindowReport) -> io::Result<()> {
    let verdict = decision_text(&report.decision);
    let (start, end) = (report.t_start_us as f64 * 1e-6, report.t_end_us as f64 * 1e-6);
    writeln!(out, "         {start:8.2} to {end:8.2} s  {verdict}")?;
    if let (Some(before), Some(after)) = (report.cost_before, report.cost_after) {
        let searched = optimizer_name(report.optimizer);
        let evaluations = report.evaluations;
        write!(out, "           cost {before:.4} -> {after:.4}, {searched}, {evaluations} evaluations")?;
        writeln!(out, ", {:.1} s of rest", report.rest_s)?;
    }
    window_note(report, config).map_or(Ok(()), |note| writeln!(out, "           {note}"))
}

const fn optimizer_name(kind: OptimizerKind) -> &'static str {
    match kind {
        OptimizerKind::Imoa => "IMOA",
        OptimizerKind::ImoaLiteral => "IMOA as printed",
        OptimizerKind::Moa => "MOA",
        OptimizerKind::Pso => "particle swarm",
        OptimizerKind::De => "differential evolution",
        OptimizerKind::Random => "random search",
        OptimizerKind::Lm => "Levenberg-Marquardt",
        OptimizerKind::Ls => "least squares",
        _ => "search",
    }
}

fn print_parameters(out: &mut impl Write, layout: Layout, last: &Parameters) -> io::Result<()> {
    let (p_sigma, b_sigma) = last.sigma.split_at(9);
    let cells = last.p.iter().zip(p_sigma);
    match layout {
        Layout::Table => {
            let cells: Vec<String> = cells.map(|(x, s)| format!("{:>8} +- {s:.5}", fixed(*x, 5))).collect();
            for (row, cells) in cells.chunks(3).enumerate() {
                let label = if row == 0 { "final P " } else { "        " };
                writeln!(out, "{label} {}", cells.join("   "))?;
            }
        }
        Layout::Lines => {
            let cells: Vec<String> = cells.map(|(x, s)| format!("{} +- {s:.5}", fixed(*x, 5))).collect();
            writeln!(out, "final P  {}, row by row", cells.join(", "))?;
        }
    }
    let in_deg = |x: f32| x.to_degrees();
    let cells: Vec<String> =
        last.b_rad_s.iter().zip(b_sigma).map(|(&b, &s)| format!("{:8.4} +- {:.4} ", in_deg(b), in_deg(s))).collect();
    // Nothing states how well a bias from rest is known.
    let prior = if last.is_prior { " (+- prior)" } else { "" };
    let b = match layout {
        Layout::Table => cells.join("   "),
        Layout::Lines => cells.iter().map(|cell| cell.trim()).collect::<Vec<_>>().join(", "),
    };
    writeln!(out, "final b  {b}  deg/s{prior}; {} of 12 directions observed", last.rank)
}

const MODELS: [&str; 4] = ["uncompensated", "bias only", "12 param.", "flown"];

fn print_scores(out: &mut impl Write, layout: Layout, flight: &Flight, reference: &Reference) -> io::Result<()> {
    let part = if flight.frozen_at_us.is_some() { "held out" } else { "whole trace" };
    let rows = [
        (["rotation over 2 s, deg rms"; 2], &reference.orientation_2s_rms_deg),
        (
            ["  one delay fitted", "rotation over 2 s with one delay fitted, deg rms"],
            &reference.orientation_2s_rms_time_aligned_deg,
        ),
        (["gravity at rests, deg"; 2], &reference.rest_gravity_deg),
    ];
    let is_scored = |(_, scores): &([&str; 2], &PerModel)| **scores != PerModel::default();
    let head = format!("scores   {part}");
    // A trace may have a reference only where nothing is scored by it: then there is no header without rows.
    let has_header = layout == Layout::Table && rows.iter().any(is_scored);
    if has_header {
        writeln!(out, "{head:<34} {}", MODELS.map(|name| format!("{name:>12}")).join(" "))?;
    }
    for ([in_table, in_line], scores) in rows.into_iter().filter(is_scored) {
        let cells = [scores.uncompensated, scores.bias_only, scores.twelve_parameters, scores.with_effects].map(figure);
        match layout {
            Layout::Table => {
                writeln!(out, "         {in_table:<25} {}", cells.map(|cell| format!("{cell:>12}")).join(" "))?;
            }
            Layout::Lines => writeln!(out, "{head}, {in_line}: {}", named(MODELS, &cells))?,
        }
    }
    let below = if has_header { " ".repeat(8) } else { format!("{head},") };
    if let Some(delay) = reference.time_alignment_ms {
        writeln!(out, "{below} fitted delay {} ms", fixed(delay, 2))?;
    }
    let attitude = &reference.attitude_rms_deg;
    if attitude.total.is_some() {
        let [total, heading, inclination] = [attitude.total, attitude.heading, attitude.inclination].map(figure);
        writeln!(out, "{below} attitude, deg rms: {total} total, {heading} heading, {inclination} inclination")?;
    }
    Ok(())
}

fn figure(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"))
}

/// Prints the verdict and the effects found.
fn print_diagnosed(out: &mut impl Write, config: &Config, diagnosed: &Diagnosed) -> io::Result<()> {
    if !config.effects {
        return writeln!(out, "effects  not looked for");
    }
    let residual = &diagnosed.residual.magnetic_deg;
    write!(out, "effects  {}", verdict_name(diagnosed.verdict))?;
    match (residual.before, residual.after) {
        (Some(before), Some(after)) => {
            writeln!(out, "; residual of the field over a second {before:.2} -> {after:.2} deg")?
        }
        _ => writeln!(out)?,
    }
    sentences(diagnosed).iter().try_for_each(|sentence| writeln!(out, "         {sentence}"))
}
