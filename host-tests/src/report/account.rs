//! The account of a diagnosis, as text.

use std::io::{self, Write};

use meerkat_mwd::{
    compensation::{Effect, Sensor},
    diagnosis::{DiagnosisReport, EffectReport, Verdict},
    magnet::HardIronInterval,
};

use super::{plain_words::use_of_field, remainder_text::remainder_text};
use crate::{
    diagnosis::{BeforeAfter, Diagnosed, Found, rival_of_other_sensor, rivals, why_left_in},
    number::fixed,
};
use testbed::{
    flight::Flight,
    score::{PerModel, Reference},
    trace::{Trace, seconds},
};

/// Prints the whole account.
///
/// # Errors
/// When `out` takes no more.
pub fn print_account(
    out: &mut impl Write,
    trace: &Trace,
    flight: &Flight,
    diagnosed: &Diagnosed,
    reference: Option<&Reference>,
) -> io::Result<()> {
    writeln!(out, "trace     {}: {} samples, {:.2} s", trace.path.display(), trace.len(), trace.duration_s())?;
    for wrong in &trace.wrong {
        writeln!(out, "WRONG     {wrong}; nothing is identified from it")?;
    }
    for note in &trace.notes {
        writeln!(out, "note      {note}")?;
    }
    if let Some(freeze_us) = flight.frozen_at_us {
        writeln!(
            out,
            "hold-out  effects frozen from {} s; residuals and scores are over what follows",
            seconds(freeze_us)
        )?;
    }
    for (report, library) in &diagnosed.reports {
        print_report(out, report, library)?;
    }
    print_outcome(out, diagnosed)?;
    let residual = &diagnosed.residual;
    let figure = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.3}"));
    for (name, before_after) in [("gravity", &residual.gravity_deg), ("field", &residual.magnetic_deg)] {
        if before_after.before.is_none() && before_after.after.is_none() {
            continue;
        }
        let (before, after) = (figure(before_after.before), figure(before_after.after));
        writeln!(out, "residual  {name} over a second: {before} -> {after} deg rms")?;
    }
    if let Some(reference) = reference {
        let scores = &reference.orientation_2s_rms_deg;
        let aligned = &reference.orientation_2s_rms_time_aligned_deg;
        for (name, scores) in [("as it is", scores), ("one delay taken out", aligned)] {
            if *scores == PerModel::default() {
                continue;
            }
            let cells = [scores.bias_only, scores.twelve_parameters, scores.with_effects].map(figure);
            let [bias, twelve, flown] = cells;
            writeln!(
                out,
                "rotation  over 2 s, {name}: bias only {bias}, 12 parameters {twelve}, with effects {flown} deg rms"
            )?;
        }
    }
    Ok(())
}

/// Prints a diagnosis: one line for it, one for each effect found, one for the other candidates.
pub(crate) fn print_report(
    out: &mut impl Write,
    report: &DiagnosisReport,
    library: &[&'static dyn Effect],
) -> io::Result<()> {
    writeln!(
        out,
        "diagnosis {:.2} to {:.2} s: NIS {:.2} with the gyro's parameters alone, {:.2} with what was found; {}",
        report.t_start_us as f64 * 1e-6,
        report.t_end_us as f64 * 1e-6,
        report.nis[0],
        report.nis[1],
        verdict_name(report.verdict),
    )?;
    for effect in report.found() {
        let Some(of) = library.get(usize::from(effect.found.index)) else { continue };
        let why = why_left_in(rival_of_other_sensor(effect, library));
        let remark = if effect.is_taken_out() { String::new() } else { format!("; not taken out{why}") };
        let rivals = rivals(effect, library);
        let rivals = if rivals.is_empty() { String::new() } else { format!("; as likely: {}", rivals.join(", ")) };
        writeln!(
            out,
            "  found   {}: log Bayes factor {:.0}, {}{rivals}{remark}",
            of.name(),
            effect.evidence,
            size(effect, *of),
        )?;
    }
    let tried = report.tried.iter().zip(library).take(report.candidates.into()).enumerate();
    let others = tried.filter(|(index, _)| report.found().all(|effect| usize::from(effect.found.index) != *index));
    let words: Vec<String> =
        others.map(|(_, (tried, effect))| format!("{} {}", effect.name(), fixed(*tried, 1))).collect();
    writeln!(out, "  others  log Bayes factor beside these: {}", words.join(", "))?;
    if report.verdict == Verdict::UnexplainedResidual {
        writeln!(out, "  {}", remainder_text(&report.remainder))?;
    }
    Ok(())
}

/// Size of an effect with its deviation: of a vector sensor as the turn of its vector, of the gyro as a rate.
pub(crate) fn size(found: &EffectReport, effect: &dyn Effect) -> String {
    let [size, sigma] = [found.size_rad, found.size_sigma_rad].map(f32::to_degrees);
    match effect.sensor() {
        Sensor::Gyro => format!("adds {size:.3} +- {sigma:.3} deg/s rms"),
        _ => format!("turns its vector by {size:.2} +- {sigma:.2} deg rms"),
    }
}

fn print_outcome(out: &mut impl Write, diagnosed: &Diagnosed) -> io::Result<()> {
    writeln!(out, "verdict   {}", verdict_name(diagnosed.verdict))?;
    for sentence in sentences(diagnosed) {
        writeln!(out, "  {sentence}")?;
    }
    Ok(())
}

/// Effects and magnets that were found, one sentence each.
#[must_use]
pub fn sentences(diagnosed: &Diagnosed) -> Vec<String> {
    diagnosed.effects.iter().map(sentence).chain(diagnosed.magnets.iter().map(of_magnet)).collect()
}

fn of_magnet(magnet: &HardIronInterval) -> String {
    let [x, y, z] = magnet.offset_ut;
    let size = f64::from(x * x + y * y + z * z).sqrt();
    let until = magnet.to_us.map_or_else(|| "the end".to_owned(), |to_us| format!("{:.1} s", to_us as f64 * 1e-6));
    let remark = use_of_field(magnet);
    let from_s = magnet.from_us as f64 * 1e-6;
    let offset = [x, y, z].map(|x| fixed(x, 1)).join(", ");
    format!("hard_iron from {from_s:.1} s to {until}: {size:.1} uT, ({offset}) uT, {remark}")
}

/// An effect in one sentence.
fn sentence(found: &Found) -> String {
    let parameters = found.effect.parameters().iter().enumerate().map(|(k, parameter)| {
        let value = found.report.found.parameters.get(k).copied().unwrap_or(0.0) * parameter.in_unit;
        let sigma = found.report.found.sigma.get(k).copied().unwrap_or(0.0) * parameter.in_unit;
        format!("{} {} +- {sigma:.3}", parameter.name, fixed(value, 3))
    });
    let since = if found.effect.is_bias_step() {
        format!(" at {:.1} s", found.report.step_us as f64 * 1e-6)
    } else {
        String::new()
    };
    let taken_out = if found.report.is_taken_out() {
        format!("taken out from {:.1} s on", found.report.taken_out_us as f64 * 1e-6)
    } else {
        format!("not taken out{}", found.why_left_in())
    };
    let residual = match found.residual_deg() {
        BeforeAfter { before: Some(before), after: Some(after) } => {
            format!("; residual over a second without it {before:.3}, with it {after:.3} deg rms")
        }
        _ => String::new(),
    };
    let aliases = found.aliases().join(", ");
    let aliases = if aliases.is_empty() { aliases } else { format!("; also {aliases}") };
    format!(
        "{}{since}: {}; {taken_out}{residual}{aliases}",
        found.effect.name(),
        parameters.collect::<Vec<_>>().join(", "),
    )
}

/// Name of a verdict, as in the JSON.
#[must_use]
pub const fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::ModelSufficient => "model_sufficient",
        Verdict::EffectsFound => "effects_found",
        Verdict::NotEnoughExcitation => "not_enough_excitation",
        _ => "unexplained_residual",
    }
}
