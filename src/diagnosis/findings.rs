//! Effects that fly, since when, and the windows' reports on them. The evidence itself is computed in
//! `estimator/candidates/evidence.rs`; an effect is named and taken out here, at the instant of an update.

use super::{DiagnosisReport, EffectReport, Verdict};
use crate::{
    compensation::{ActiveEffects, Effect, FoundEffect, Sensor, effect::MAX_PARAMETERS},
    config::Config,
    estimator::{Claim, Estimator, MAX_CLAIMED, Refusal},
};
use heapless::Vec;

/// Effects that fly, and their reports.
pub(crate) struct Findings<const REPORTS: usize> {
    flown: ActiveEffects,
    /// Report of the latest update, which waits for the instant at which it takes effect; true if its effects are to
    /// fly then.
    waiting: Vec<(DiagnosisReport, bool), 1>,
    /// Effects of the last report whose model flew.
    known: [EffectReport; MAX_CLAIMED],
    known_count: usize,
    /// Reports waiting to be taken.
    pending: Vec<DiagnosisReport, REPORTS>,
    /// Number of reports dropped for want of room, because nobody took them.
    pub lost: u32,
}

impl<const REPORTS: usize> Findings<REPORTS> {
    pub const fn zero() -> Self {
        const NONE: EffectReport = EffectReport {
            found: FoundEffect { index: 0, parameters: [0.0; 9], sigma: [0.0; 9] },
            evidence: 0.0,
            size_rad: 0.0,
            size_sigma_rad: 0.0,
            rivals: 0,
            step_us: 0,
            found_us: 0,
            taken_out_us: 0,
        };
        Self {
            flown: ActiveEffects::none(),
            waiting: Vec::new(),
            known: [NONE; MAX_CLAIMED],
            known_count: 0,
            pending: Vec::new(),
            lost: 0,
        }
    }

    /// Forgets everything found, at a new configuration.
    pub fn start(&mut self) {
        self.flown = ActiveEffects::none();
        self.waiting.clear();
        self.known_count = 0;
        self.pending.clear();
        self.lost = 0;
    }

    /// Returns the effects that are taken out.
    pub const fn flown(&self) -> &ActiveEffects {
        &self.flown
    }

    /// Flies restored effects from the first sample on.
    #[cfg(feature = "storage")]
    pub const fn restore(&mut self, effects: &ActiveEffects) {
        self.flown = *effects;
    }

    /// Reports the effects of a posterior. `fitness`: whether it may fly; `flies`: its model is to fly, and its effects
    /// too.
    #[inline(never)]
    pub fn judge<const NODES: usize, const COLUMNS: usize>(
        &mut self,
        [t_start_us, t_end_us]: [u64; 2],
        estimator: &Estimator<f32, NODES, COLUMNS>,
        (fitness, flies): (Result<(), Refusal>, bool),
        config: &Config,
    ) {
        let library = estimator.library();
        let mut report = DiagnosisReport {
            t_start_us,
            t_end_us,
            t_effect_us: 0,
            verdict: verdict(fitness, estimator),
            effects: [EffectReport::default(); MAX_CLAIMED],
            count: 0,
            tried: *estimator.tried(),
            candidates: estimator.candidates(),
            nis: estimator.nis_of_claims(),
            remainder: estimator.remainder(),
        };
        if report.verdict != Verdict::UnexplainedResidual {
            report.remainder = crate::estimator::RemainderReport::default();
        }
        for (slot, claim) in report.effects.iter_mut().zip(estimator.claims()) {
            let Some(effect) = library.get(usize::from(claim.effect)) else { continue };
            *slot = self.told(*effect, claim, t_end_us, estimator.field_ut(), config);
            report.count += 1;
        }
        self.waiting.clear();
        // The list was just emptied, so there is room.
        let _ = self.waiting.push((report, flies));
    }

    /// Turns a claim into the report of its effect.
    fn told(&self, effect: &dyn Effect, claim: &Claim, t_us: u64, field_ut: f32, config: &Config) -> EffectReport {
        let mut found = FoundEffect { index: claim.effect, parameters: claim.parameters, sigma: claim.sigma };
        if let Some(delay_s) = found.parameters.first_mut() {
            *delay_s += late_already_s(effect, &claim.parameters, config);
        }
        let unit = match effect.sensor() {
            Sensor::Gyro => 1.0,
            Sensor::Accelerometer => config.earth.gravity_m_s2,
            Sensor::Magnetometer => field_ut,
        };
        let is_same = |known: &&EffectReport| known.found.index == claim.effect && known.step_us == claim.step_us;
        let known = self.known.iter().take(self.known_count).find(is_same);
        EffectReport {
            found,
            evidence: claim.evidence,
            size_rad: if unit > 0.0 { claim.size / unit } else { 0.0 },
            size_sigma_rad: if unit > 0.0 { claim.size_sigma / unit } else { 0.0 },
            rivals: claim.rivals.bits(),
            step_us: claim.step_us,
            found_us: known.map_or(t_us, |known| known.found_us),
            // The time is set when the update takes effect.
            taken_out_us: if claim.is_taken_out { known.map_or(0, |known| known.taken_out_us) } else { 0 },
        }
        .marked(claim.is_taken_out)
    }

    /// Lets the result of an update take effect. Returns `None` if the effects taken out stay the same, else
    /// `Some(true)` if an effect of the magnetometer has come or gone.
    // Inlined, its reports would lie on the stack under all work on a sample.
    #[inline(never)]
    pub fn take_effect(&mut self, t_us: u64, is_window: bool, library: &[&dyn Effect]) -> Option<bool> {
        let (mut report, flies) = self.waiting.pop()?;
        report.t_effect_us = t_us;
        let before = self.flown;
        for effect in report.effects.iter_mut().take(usize::from(report.count)) {
            // A restored effect flies before any update has taken it out.
            let flew = effect.step_us == 0 && before.iter().any(|found| found.index == effect.found.index);
            effect.taken_out_us = match effect.taken_out_us {
                TO_BE_TAKEN_OUT if flies || flew => t_us,
                TO_BE_TAKEN_OUT => 0,
                us => us,
            };
        }
        if flies {
            self.flown = report.active();
            (self.known, self.known_count) = (report.effects, usize::from(report.count));
        }
        if is_window {
            if self.pending.is_full() {
                self.pending.remove(0);
                self.lost = self.lost.saturating_add(1);
            }
            // The list has room now.
            let _ = self.pending.push(report);
        }
        let of_field = |effects: &ActiveEffects| {
            effects.iter().fold(0_u32, |all, found| {
                let effect = library.get(usize::from(found.index));
                let is_of_field = effect.is_some_and(|effect| effect.sensor() == Sensor::Magnetometer);
                if is_of_field { all | 1_u32.checked_shl(found.index.into()).unwrap_or(0) } else { all }
            })
        };
        (self.flown != before).then(|| of_field(&self.flown) != of_field(&before))
    }

    /// Drops the result of an update that was not ready in time.
    pub fn drop_waiting(&mut self) {
        self.waiting.clear();
    }

    /// Returns the oldest report that nobody has taken.
    pub fn take(&mut self) -> Option<DiagnosisReport> {
        (!self.pending.is_empty()).then(|| self.pending.remove(0))
    }
}

/// Delay, seconds, by which a delay of the whole gyro exceeds the estimator's: a rate of unknown time is taken as the
/// mean over the interval that it ends, so it is half an interval late already. 0 for any other effect.
fn late_already_s(effect: &dyn Effect, parameters: &[f32; MAX_PARAMETERS], config: &Config) -> f32 {
    let is_late = effect.gyro_delay_s(parameters) != 0.0 && config.latency.gyro_s.is_none();
    if is_late { config.sample_period_us as f32 * 0.5e-6 } else { 0.0 }
}

/// Effects that flew, as the estimator has them.
#[cfg(feature = "storage")]
pub(crate) fn as_estimated(flown: &ActiveEffects, library: &[&dyn Effect], config: &Config) -> ActiveEffects {
    let mut estimated = ActiveEffects::none();
    for found in flown.iter() {
        let mut found = *found;
        let effect = library.get(usize::from(found.index));
        let late_s = effect.map_or(0.0, |effect| late_already_s(*effect, &found.parameters, config));
        if let Some(delay_s) = found.parameters.first_mut() {
            *delay_s -= late_s;
        }
        // The new set has room for all effects of the old one.
        estimated.add(found);
    }
    estimated
}

/// Placeholder of an effect's `taken_out_us` until the update that takes it out first takes effect.
const TO_BE_TAKEN_OUT: u64 = u64::MAX;

impl EffectReport {
    fn marked(mut self, is_taken_out: bool) -> Self {
        if is_taken_out && self.taken_out_us == 0 {
            self.taken_out_us = TO_BE_TAKEN_OUT;
        }
        self
    }
}

fn verdict<const NODES: usize, const COLUMNS: usize>(
    fitness: Result<(), Refusal>,
    estimator: &Estimator<f32, NODES, COLUMNS>,
) -> Verdict {
    match fitness {
        Err(Refusal::Diverged { .. } | Refusal::WrongMounting { .. }) => Verdict::UnexplainedResidual,
        Err(_) => Verdict::NotEnoughExcitation,
        Ok(()) if estimator.is_unexplained() => Verdict::UnexplainedResidual,
        Ok(()) if estimator.claims().is_empty() => Verdict::ModelSufficient,
        Ok(()) => Verdict::EffectsFound,
    }
}

#[cfg(all(test, feature = "storage"))]
mod tests;
