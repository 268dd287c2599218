//! What a flight's diagnoses come to.

use meerkat_mwd::{
    Config,
    compensation::Effect,
    diagnosis::{DiagnosisReport, EffectReport, HardIronInterval, RemainderReport, Verdict},
};

use super::vector_residual::{ResidualOverTime, VectorResidual, vector_residual};
use crate::{flight::Flight, trace::Trace};

/// The outcome of the loop.
#[derive(Clone)]
pub struct Diagnosed {
    /// The verdict at the end.
    pub verdict: Verdict,
    /// The effects that it holds.
    pub effects: Vec<Found>,
    /// Magnets that came and went.
    pub magnets: Vec<HardIronInterval>,
    /// Every diagnosis that could tell anything, with the library that it used.
    pub reports: Vec<(DiagnosisReport, &'static [&'static dyn Effect])>,
    /// Residual of the vectors with the bias alone, and with all that flew.
    pub residual: VectorResidual,
    /// What they are made of.
    pub residual_over_time: ResidualOverTime,
}

impl Diagnosed {
    /// What the residual goes with, where the verdict is that it is not explained.
    #[must_use]
    pub fn remainder(&self) -> Option<&RemainderReport> {
        let latest_first = self.reports.iter().rev().map(|(report, _)| report);
        let unexplained = latest_first.filter(|report| report.verdict == Verdict::UnexplainedResidual);
        unexplained
            .take(usize::from(self.verdict == Verdict::UnexplainedResidual))
            .map(|report| &report.remainder)
            .next()
    }
}

/// An effect with what it is.
#[derive(Clone, Copy)]
pub struct Found {
    /// Out of the library.
    pub effect: &'static dyn Effect,
    /// How it was found.
    pub report: EffectReport,
    /// From when to when it is taken out, or is there, seconds.
    pub active_s: [f64; 2],
}

/// What the diagnoses of a flight with the default library come to.
#[must_use]
pub fn diagnosed(trace: &Trace, config: &Config, flight: &Flight) -> Diagnosed {
    diagnosed_with(&meerkat_mwd::compensation::effects::LIBRARY, trace, config, flight)
}

/// The same with another library.
pub(super) fn diagnosed_with(
    library: &'static [&'static dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
) -> Diagnosed {
    let reports: Vec<_> = flight.diagnoses.iter().filter(|report| report.is_conclusive()).collect();
    let end_s = trace.samples.last().map_or(0.0, |sample| sample.t_us as f64 / 1e6);
    let mut effects: Vec<Found> = Vec::new();
    for report in &reports {
        // What flies follows it for good, and no later diagnosis shows it again.
        let Some(step) = report.bias_step else { continue };
        let found = report.found().find(|found| found.found.index == step.effect);
        let Some((found, &effect)) = found.zip(library.get(usize::from(step.effect))) else { continue };
        effects.push(Found { effect, report: *found, active_s: [step.t_us as f64 / 1e6, end_s] });
    }
    if let Some(last) = reports.last() {
        for report in last.found() {
            let Some(&effect) = library.get(usize::from(report.found.index)) else { continue };
            if effect.is_bias_step() {
                continue;
            }
            // Since when every diagnosis has found it.
            let holding = reports.iter().rev().take_while(|r| r.found().any(|f| f.found.index == report.found.index));
            let from_us = holding.last().map_or(last.t_start_us, |first| first.t_start_us);
            effects.push(Found { effect, report: *report, active_s: [from_us as f64 / 1e6, end_s] });
        }
    }
    let verdict = match reports.last().map_or(Verdict::NotEnoughExcitation, |last| last.verdict) {
        Verdict::ModelSufficient | Verdict::NotEnoughExcitation
            if !flight.magnets.is_empty() || !effects.is_empty() =>
        {
            Verdict::EffectsFound
        }
        verdict => verdict,
    };
    let (residual, residual_over_time) = vector_residual(library, trace, config, flight);
    Diagnosed {
        verdict,
        effects,
        magnets: flight.magnets.clone(),
        reports: reports.into_iter().map(|report| (*report, library)).collect(),
        residual,
        residual_over_time,
    }
}
