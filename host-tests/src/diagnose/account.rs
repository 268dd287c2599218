//! The account that a user reads.

use std::io::{self, Write};

use meerkat_mwd::{
    Config,
    compensation::Effect,
    diagnosis::{DiagnosisReport, HardIronInterval, Verdict},
};

use super::{
    outcome::{Diagnosed, Found},
    remainder_text::remainder_text,
};
use crate::{
    score::Reference,
    trace::{Trace, seconds},
};

/// Prints the whole account.
///
/// # Errors
/// When `out` takes no more.
pub fn print_account(
    out: &mut impl Write,
    trace: &Trace,
    config: &Config,
    diagnosed: &Diagnosed,
    reference: Option<&Reference>,
) -> io::Result<()> {
    writeln!(out, "trace     {}: {} samples, {:.2} s", trace.path.display(), trace.samples.len(), trace.duration_s())?;
    if let Some(freeze_us) = config.freeze_at_us {
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
        let (before, after) = (figure(before_after.before), figure(before_after.after));
        writeln!(out, "residual  {name} over a second: {before} -> {after} deg rms")?;
    }
    if let Some(reference) = reference {
        let scores = &reference.orientation_2s_rms_deg;
        let aligned = &reference.orientation_2s_rms_time_aligned_deg;
        for (name, scores) in [("as it is", scores), ("one delay taken out", aligned)] {
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

/// One line a diagnosis, one an effect, one for what else was tried.
pub(crate) fn print_report(out: &mut impl Write, report: &DiagnosisReport, library: &[&dyn Effect]) -> io::Result<()> {
    let [_, field] = report.residual_before_rad.map(f32::to_degrees);
    let [gravity_after, field_after] = report.residual_after_rad.map(f32::to_degrees);
    let gravity = report.residual_before_rad[0].to_degrees();
    writeln!(
        out,
        "diagnosis {:.2} to {:.2} s: residual of gravity {gravity:.2} -> {gravity_after:.2}, of the field {field:.3} -> {field_after:.3} deg; NIS {:.1} -> {:.1}; {}",
        report.t_start_us as f64 * 1e-6,
        report.t_end_us as f64 * 1e-6,
        report.nis[0],
        report.nis[1],
        verdict_name(report.verdict),
    )?;
    for effect in report.found() {
        let Some(of) = library.get(usize::from(effect.found.index)) else { continue };
        let remark = if effect.believed {
            ""
        } else {
            ": too little of it is seen, more than it can be, or P has it in, so named and not taken out"
        };
        writeln!(
            out,
            "  added   {}: evidence {:.0}, chance {:.4}, turns its vector by {:.2} +- {:.2} deg rms{remark}",
            of.name(),
            effect.evidence,
            effect.p_value,
            effect.size_rad.to_degrees(),
            effect.size_sigma_rad.to_degrees(),
        )?;
    }
    let tried = report.tried.iter().zip(library).take(report.candidates.into()).enumerate();
    let refused = tried.filter(|(index, _)| report.found().all(|effect| usize::from(effect.found.index) != *index));
    let words: Vec<String> = refused
        .map(|(_, (tried, effect))| {
            let why = match (tried.too_small, tried.suspected) {
                (true, _) => " too small",
                (_, true) => " suspected, but the field's residual is unexplained",
                _ => "",
            };
            format!("{} {:.0} ({:.2}){why}", effect.name(), tried.evidence, tried.p_value)
        })
        .collect();
    writeln!(out, "  refused evidence (chance): {}", words.join(", "))?;
    if report.verdict == Verdict::UnexplainedResidual {
        writeln!(out, "  {}", remainder_text(&report.remainder))?;
    }
    Ok(())
}

fn print_outcome(out: &mut impl Write, diagnosed: &Diagnosed) -> io::Result<()> {
    writeln!(out, "verdict   {}", verdict_name(diagnosed.verdict))?;
    for sentence in sentences(diagnosed) {
        writeln!(out, "  {sentence}")?;
    }
    Ok(())
}

/// What was found, an effect in a line.
#[must_use]
pub fn sentences(diagnosed: &Diagnosed) -> Vec<String> {
    diagnosed.effects.iter().map(sentence).chain(diagnosed.magnets.iter().map(of_magnet)).collect()
}

fn of_magnet(magnet: &HardIronInterval) -> String {
    let [x, y, z] = magnet.offset_ut;
    let size = f64::from(x * x + y * y + z * z).sqrt();
    let until = magnet.to_us.map_or_else(|| "the end".to_owned(), |to_us| format!("{:.1} s", to_us as f64 * 1e-6));
    let remark = if magnet.corrected { "taken out" } else { "the field is not used while it lasts" };
    let from_s = magnet.from_us as f64 * 1e-6;
    format!("hard_iron from {from_s:.1} s to {until}: {size:.1} uT, ({x:.1}, {y:.1}, {z:.1}) uT, {remark}")
}

/// One effect in a line.
fn sentence(found: &Found) -> String {
    let parameters = found.effect.parameters().iter().enumerate().map(|(k, parameter)| {
        let value = found.report.found.parameters.get(k).copied().unwrap_or(0.0) * parameter.in_unit;
        let sigma = found.report.found.sigma.get(k).copied().unwrap_or(0.0) * parameter.in_unit;
        format!("{} {value:.3} +- {sigma:.3}", parameter.name)
    });
    format!(
        "{}: {}; also {}",
        found.effect.name(),
        parameters.collect::<Vec<_>>().join(", "),
        found.effect.aliases().join(", ")
    )
}

/// The verdict as the JSON spells it.
#[must_use]
pub const fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::ModelSufficient => "model_sufficient",
        Verdict::EffectsFound => "effects_found",
        Verdict::NotEnoughExcitation => "not_enough_excitation",
        _ => "unexplained_residual",
    }
}
