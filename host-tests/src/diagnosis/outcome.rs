//! What a flight's diagnoses come to.

use meerkat_mwd::{
    Config,
    compensation::Effect,
    diagnosis::{DiagnosisReport, EffectReport, RemainderReport, Verdict},
    magnet::HardIronInterval,
};

use super::vector_residual::{BeforeAfter, ResidualOverTime, VectorResidual, residual_without, vector_residual};
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
#[derive(Clone)]
pub struct Found {
    /// Out of the library.
    pub effect: &'static dyn Effect,
    /// How it was found.
    pub report: EffectReport,
    /// From when to when it is there, seconds: since it was found, or since the bias stepped.
    pub active_s: [f64; 2],
    /// Residual over a second of the vector that shows it, without it and with it, degrees rms.
    pub residual_deg: BeforeAfter,
    /// Effects of the library that are as likely.
    rivals: Vec<&'static str>,
}

impl Found {
    /// What it may be instead: what is as likely on these data, then what the sensors can never tell from it.
    #[must_use]
    pub fn aliases(&self) -> Vec<&'static str> {
        let own = self.effect.aliases().iter().copied().filter(|alias| !self.rivals.contains(alias));
        self.rivals.iter().copied().chain(own).collect()
    }
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
    let (residual, residual_over_time) = vector_residual(library, trace, config, flight);
    let mut effects: Vec<Found> = Vec::new();
    // A step of the bias is believed for good after a while, and no later diagnosis looks for it again.
    let mut steps: Vec<&EffectReport> = Vec::new();
    for step in reports.iter().flat_map(|report| report.found()).filter(|found| found.step_us > 0) {
        match steps.iter_mut().find(|known| known.step_us == step.step_us) {
            Some(known) => *known = step,
            None => steps.push(step),
        }
    }
    let of_last = reports.last().into_iter().flat_map(|last| last.found()).filter(|found| found.step_us == 0);
    for report in of_last.chain(steps) {
        let Some(&effect) = library.get(usize::from(report.found.index)) else { continue };
        let from_us = if report.step_us > 0 { report.step_us } else { report.found_us };
        effects.push(Found {
            effect,
            report: *report,
            active_s: [from_us as f64 / 1e6, end_s],
            residual_deg: residual_without(library, trace, config, flight, report),
            rivals: rivals(report, library),
        });
    }
    let verdict = match reports.last().map_or(Verdict::NotEnoughExcitation, |last| last.verdict) {
        Verdict::ModelSufficient | Verdict::NotEnoughExcitation
            if !flight.magnets.is_empty() || !effects.is_empty() =>
        {
            Verdict::EffectsFound
        }
        verdict => verdict,
    };
    Diagnosed {
        verdict,
        effects,
        magnets: flight.magnets.clone(),
        reports: reports.into_iter().map(|report| (*report, library)).collect(),
        residual,
        residual_over_time,
    }
}

/// Names of the effects that are as likely as one that was found.
#[must_use]
pub fn rivals(report: &EffectReport, library: &[&dyn Effect]) -> Vec<&'static str> {
    let is_rival = |(index, _): &(usize, &&dyn Effect)| report.rivals >> index & 1 == 1;
    library.iter().enumerate().filter(is_rival).map(|(_, effect)| effect.name()).collect()
}
