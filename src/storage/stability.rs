//! Decision whether the flown model is worth storing: only one that several windows in succession have confirmed.

use super::{StoreReason, StoredModel};
use crate::{
    compensation::{ActiveEffects, GyroModel},
    identification::{Decision, Refusal, WindowReport},
    sample::{Sample, SampleFlags, is_temperature},
};

/// Windows in succession that have to leave P as it is, within its deviations. A window closes every 25 s, so P has
/// then held through 50 s of samples that it did not come from.
pub const STABLE_WINDOWS: u8 = 3;

/// Largest change of P between windows that counts as none, in its deviations: by chance one of nine elements changes
/// more in 2 % of windows.
const SAME_SIGMAS: f32 = 3.0;

/// Least time between two models of a session, microseconds. A sector of 16 KiB takes some 80 models of the usual 160
/// to 200 bytes, and after power-up at least half of two sectors is free: 40 hours of drilling without a pause in which
/// to erase.
pub const BETWEEN_STORES_US: u64 = 30 * 60 * 1_000_000;

/// Gate that decides when the flown model is worth a record.
///
/// A model is worth a record if P is not the factory's, [`STABLE_WINDOWS`] windows in succession have confirmed P, and
/// it differs from the last one stored: in P or an effect's parameter by more than its deviation, in its list of
/// effects, or in temperature by 10 K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityGate {
    factory_p: [[f32; 3]; 3],
    /// P that the present count of windows confirms.
    p: [[f32; 3]; 3],
    effects: ActiveEffects,
    /// Deviations of P, from the latest window that accepted it.
    sigma: [f32; 12],
    agreeing: u8,
    range_c: Option<[f32; 2]>,
    stored: Option<StoredModel>,
    /// True if `stored` is of this session, and its time of this clock.
    stored_here: bool,
}

impl StabilityGate {
    /// Gate of a probe with this factory model, into which `restored` was restored.
    #[must_use]
    pub fn new(factory: &GyroModel, restored: Option<&StoredModel>) -> Self {
        Self {
            factory_p: factory.p,
            p: restored.map_or(factory.p, |model| model.gyro.p),
            effects: restored.map_or(ActiveEffects::none(), |model| model.effects),
            sigma: restored.map_or([0.0; 12], |model| model.sigma),
            agreeing: 0,
            range_c: None,
            stored: restored.copied(),
            stored_here: false,
        }
    }

    /// Notes a sample's temperature.
    pub fn sample(&mut self, sample: &Sample) {
        let t = sample.temperature_c;
        if sample.flags.intersects(SampleFlags::TEMPERATURE_MISSING | SampleFlags::FAULT) || !is_temperature(t) {
            return;
        }
        let [low, high] = self.range_c.unwrap_or([t, t]);
        self.range_c = Some([if t < low { t } else { low }, if t > high { t } else { high }]);
    }

    /// Lowest and highest temperature since P and the effects last changed, degrees Celsius.
    #[must_use]
    pub const fn temperature_c(&self) -> Option<[f32; 2]> {
        self.range_c
    }

    /// Takes a window's report once it has taken effect, with the flown model. Returns the model if it is worth a
    /// record. It counts as stored from [`StabilityGate::stored`] on. `library` is the
    /// [`fingerprint`](super::fingerprint) of what the effects are relative to.
    pub fn window(
        &mut self,
        report: &WindowReport,
        gyro: &GyroModel,
        effects: &ActiveEffects,
        library: u32,
    ) -> Option<StoredModel> {
        let same_effects = effects.iter().map(|found| found.index).eq(self.effects.iter().map(|found| found.index));
        if report.decision == Decision::Accepted {
            self.sigma = report.sigma;
        }
        let same_p = same_p(&self.p, &gyro.p, &self.sigma, SAME_SIGMAS);
        let agrees = agrees(report.decision);
        let is_other = !same_p || !same_effects;
        if is_other || agrees == Some(false) {
            (self.agreeing, self.range_c) = (0, self.range_c.filter(|_| !is_other));
            self.p = gyro.p;
        }
        if agrees == Some(true) {
            self.agreeing = self.agreeing.saturating_add(1);
        }
        self.effects = *effects;
        if self.agreeing < STABLE_WINDOWS || gyro.p == self.factory_p {
            return None;
        }
        let model = StoredModel {
            gyro: *gyro,
            sigma: self.sigma,
            effects: *effects,
            library,
            temperature_c: self.range_c,
            t_us: report.t_end_us,
            reason: StoreReason::Stable { windows: self.agreeing },
        };
        self.is_news(&model).then_some(model)
    }

    /// Notes that the model has been stored.
    pub const fn stored(&mut self, model: &StoredModel) {
        (self.stored, self.stored_here) = (Some(*model), true);
    }

    fn is_news(&self, model: &StoredModel) -> bool {
        let Some(stored) = &self.stored else { return true };
        if self.stored_here && model.t_us < stored.t_us.saturating_add(BETWEEN_STORES_US) {
            return false;
        }
        let same_effects = model.effects.iter().count() == stored.effects.iter().count()
            && model.effects.iter().zip(stored.effects.iter()).all(|(new, old)| {
                let pairs = new.parameters.iter().zip(&old.parameters).zip(&new.sigma);
                new.index == old.index
                    && pairs.fold(true, |same, ((new, old), sigma)| same && libm::fabsf(new - old) <= *sigma)
            });
        let same_temperature = match (model.temperature_c, stored.temperature_c) {
            (Some([low, high]), Some([old_low, old_high])) => {
                libm::fabsf((low + high) - (old_low + old_high)) < 2.0 * super::index::BAND_K
            }
            (new, _) => new.is_none(),
        };
        !(same_p(&model.gyro.p, &stored.gyro.p, &model.sigma, 1.0) && same_effects && same_temperature)
    }
}

/// Returns true if a window confirms the flown model, false if it contradicts it, `None` if it could not judge.
pub(super) const fn agrees(decision: Decision) -> Option<bool> {
    match decision {
        Decision::Accepted => Some(true),
        Decision::Refused(Refusal::Diverged { .. } | Refusal::Implausible { .. }) => Some(false),
        Decision::Refused(_) => None,
    }
}

fn same_p(p: &[[f32; 3]; 3], other: &[[f32; 3]; 3], sigma: &[f32; 12], sigmas: f32) -> bool {
    let pairs = p.iter().flatten().zip(other.iter().flatten());
    pairs.zip(sigma).all(|((p, other), sigma)| libm::fabsf(p - other) <= sigmas * sigma)
}
