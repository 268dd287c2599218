//! Findings of all diagnoses of a flight, put together.

use meerkat_mwd::{
    Config,
    compensation::{Effect, Sensor},
    diagnosis::{DiagnosisReport, EffectReport, RemainderReport, Verdict},
    magnet::HardIronInterval,
};

use super::{
    totals::Totals,
    vector_residual::{
        BeforeAfter, ResidualOverTime, VectorResidual, WithoutEffect, residual_without, vector_residual,
    },
};
use testbed::{flight::Flight, trace::Trace};

/// Name under which a magnet is told.
pub const HARD_IRON: &str = "hard_iron";

/// Findings of a flight.
#[derive(Clone)]
pub struct Diagnosed {
    /// Verdict of the last diagnosis, raised if effects or magnets were found earlier.
    pub verdict: Verdict,
    /// Effects found and not withdrawn.
    pub effects: Vec<Found>,
    /// Magnets that came and went.
    pub magnets: Vec<HardIronInterval>,
    /// Every conclusive diagnosis, with the library of effects it used.
    pub reports: Vec<(DiagnosisReport, &'static [&'static dyn Effect])>,
    /// Residual of the vectors with the bias alone, and as flown.
    pub residual: VectorResidual,
    /// The same residuals over time, for plots.
    pub residual_over_time: ResidualOverTime,
    /// |G|, |B| and dip at the end.
    pub totals: Totals,
}

impl Diagnosed {
    /// Names of the effects that were found and stay in the readings. Of a magnet that is not taken out the field is
    /// not used, so that nothing of it stays.
    #[must_use]
    pub fn left_in(&self) -> Vec<&'static str> {
        let effects = self.effects.iter().filter(|found| !found.report.is_taken_out());
        effects.map(|found| found.effect.name()).collect()
    }

    /// Correlates of an unexplained residual; `None` unless that is the verdict.
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

/// An effect that was found.
#[derive(Clone)]
pub struct Found {
    /// The effect, from the library.
    pub effect: &'static dyn Effect,
    /// Report of the finding: evidence, parameters, times.
    pub report: EffectReport,
    /// Start and end of the effect in seconds: from when it was found, or from the bias step.
    pub active_s: [f64; 2],
    /// Residual over one second of the vector that shows the effect, without it taken out; `None` where it was not
    /// taken out.
    pub without: Option<WithoutEffect>,
    /// Names of effects that the data make as likely.
    rivals: Vec<&'static str>,
    /// The one of them that is an error of the other vector sensor.
    of_other_sensor: Option<&'static str>,
}

impl Found {
    /// Residual of the vector that shows the effect, without and with it taken out, degrees rms.
    #[must_use]
    pub fn residual_deg(&self) -> BeforeAfter {
        self.without.as_ref().map_or_else(BeforeAfter::default, |without| without.rms)
    }

    /// Why it is not taken out, in words that follow these; empty if it is, or if nothing is known of it.
    #[must_use]
    pub fn why_left_in(&self) -> String {
        if self.report.is_taken_out() { String::new() } else { why_left_in(self.of_other_sensor) }
    }

    /// Names of what it may be instead: effects as likely on these data, then effects that no data could tell
    /// from it.
    #[must_use]
    pub fn aliases(&self) -> Vec<&'static str> {
        with_own(self.effect, &self.rivals)
    }
}

fn with_own(effect: &dyn Effect, rivals: &[&'static str]) -> Vec<&'static str> {
    let own = effect.aliases().iter().copied().filter(|alias| !rivals.contains(alias));
    rivals.iter().copied().chain(own).collect()
}

/// Names of what an effect of a report may be instead, as [`Found::aliases`].
#[must_use]
pub fn aliases(effect: &dyn Effect, report: &EffectReport, library: &[&dyn Effect]) -> Vec<&'static str> {
    with_own(effect, &rivals(report, library))
}

/// Findings of a flight with the default library of effects.
#[must_use]
pub fn diagnosed(trace: &Trace, config: &Config, flight: &Flight) -> Diagnosed {
    diagnosed_with(&meerkat_mwd::compensation::effects::LIBRARY, trace, config, flight)
}

/// Findings of a flight with another library of effects.
pub(super) fn diagnosed_with(
    library: &'static [&'static dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
) -> Diagnosed {
    let reports: Vec<_> = flight.diagnoses.iter().filter(|report| report.is_conclusive()).collect();
    let end_s = trace.last_us() as f64 / 1e6;
    let (residual, residual_over_time, totals) = vector_residual(library, trace, config, flight);
    let mut effects: Vec<Found> = Vec::new();
    // A bias step is believed for good after a while, and later diagnoses do not report it again: keep the
    // last report of each.
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
            without: residual_without(library, trace, config, flight, report, &residual_over_time),
            rivals: rivals(report, library),
            of_other_sensor: rival_of_other_sensor(report, library),
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
        totals,
    }
}

/// Name of a rival that is an error of the other vector sensor: which of the two errs is then not decided, and neither
/// is taken out.
#[must_use]
pub fn rival_of_other_sensor(report: &EffectReport, library: &[&'static dyn Effect]) -> Option<&'static str> {
    let own = library.get(usize::from(report.found.index))?.sensor();
    let is_other = |sensor: Sensor| own != Sensor::Gyro && sensor != Sensor::Gyro && sensor != own;
    let rivals = library.iter().enumerate().filter(|(index, _)| report.rivals >> index & 1 == 1);
    rivals.map(|(_, effect)| *effect).find(|effect| is_other(effect.sensor())).map(|effect| effect.name())
}

/// Words on a rival of the other vector sensor, for behind "not taken out"; empty without one.
#[must_use]
pub fn why_left_in(of_other_sensor: Option<&str>) -> String {
    of_other_sensor.map_or_else(String::new, |rival| format!(": {rival}, of the other sensor, is as likely"))
}

/// Names of the library's effects that are as likely as the one found.
#[must_use]
pub fn rivals(report: &EffectReport, library: &[&dyn Effect]) -> Vec<&'static str> {
    let is_rival = |(index, _): &(usize, &&dyn Effect)| report.rivals >> index & 1 == 1;
    library.iter().enumerate().filter(is_rival).map(|(_, effect)| effect.name()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_error_of_the_other_vector_sensor_is_told_as_a_reason() {
        let library = &meerkat_mwd::compensation::effects::LIBRARY;
        let place = |name: &str| library.iter().position(|effect| effect.name() == name).unwrap_or_default();
        let mut report = EffectReport::default();
        report.found.index = u8::try_from(place("accel_bias")).unwrap_or_default();
        report.rivals = 1 << place("lever_arm") | 1 << place("gyro_lag");
        assert_eq!(rival_of_other_sensor(&report, library), None);
        report.rivals |= 1 << place("hard_iron");
        assert_eq!(rival_of_other_sensor(&report, library), Some("hard_iron"));
        assert_eq!(why_left_in(Some("hard_iron")), ": hard_iron, of the other sensor, is as likely");
        assert_eq!(why_left_in(None), "");
    }
}
