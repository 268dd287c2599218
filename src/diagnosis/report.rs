use crate::{
    compensation::{ActiveEffects, FoundEffect},
    estimator::{MAX_CLAIMED, MAX_CLAIMS, RemainderReport},
};

/// What the estimator's evidence says of the effects, when a window closed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiagnosisReport {
    /// Beginning of the window, microseconds. The evidence is of all samples since the estimator began.
    pub t_start_us: u64,
    /// Its end.
    pub t_end_us: u64,
    /// First sample from which these effects are taken out, microseconds.
    pub t_effect_us: u64,
    /// What is to be thought of the model.
    pub verdict: Verdict,
    /// The effects found.
    #[cfg_attr(feature = "serde", serde(with = "those_found"))]
    pub effects: [EffectReport; MAX_CLAIMED],
    /// How many there are.
    pub count: u8,
    /// Log Bayes factor of every candidate beside the effects found: the library's, in its order, then further steps of the bias. 0: it could not be
    /// tried, or is among those found.
    pub tried: [f32; MAX_CLAIMS],
    /// How many there are.
    pub candidates: u8,
    /// Mean squared innovation over its degrees of freedom with the gyro's parameters alone, and with all that was found.
    pub nis: [f32; 2],
    /// What the field's innovations go with, where more is left than noise; else nothing is said.
    pub remainder: RemainderReport,
}

impl DiagnosisReport {
    /// Whether it says anything about the effects.
    #[must_use]
    pub fn is_conclusive(&self) -> bool {
        self.verdict != Verdict::NotEnoughExcitation
    }

    /// The effects found.
    pub fn found(&self) -> impl Iterator<Item = &EffectReport> {
        self.effects.iter().take(usize::from(self.count))
    }

    /// Those of them that are taken out; a step of the bias is not: the bias that flies holds it.
    #[must_use]
    pub fn active(&self) -> ActiveEffects {
        let mut active = ActiveEffects::none();
        for effect in self.found().filter(|effect| effect.is_taken_out() && effect.step_us == 0) {
            active.add(effect.found);
        }
        active
    }
}

/// An effect that was found.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EffectReport {
    /// Which, and how large.
    pub found: FoundEffect,
    /// Log Bayes factor for it, beside the others that were found.
    pub evidence: f32,
    /// How much it turns its sensor's vector, or the gyro's rotation over a second: radians rms.
    pub size_rad: f32,
    /// What the deviations of its parameters alone would turn: radians rms.
    pub size_sigma_rad: f32,
    /// Other effects of the library that are as likely, one bit each: with these sensors and this motion they cannot be told apart.
    pub rivals: u32,
    /// Of a step of the bias, when it was, microseconds; else 0.
    pub step_us: u64,
    /// Since when it is found without a break, microseconds.
    pub found_us: u64,
    /// Since when it is taken out, microseconds; 0: it is not, because it is larger than it can be.
    pub taken_out_us: u64,
}

impl EffectReport {
    /// Whether it is taken out.
    #[must_use]
    pub const fn is_taken_out(&self) -> bool {
        self.taken_out_us > 0
    }
}

/// As a sequence of those that were found: the others are empty, and a line is slow.
#[cfg(feature = "serde")]
mod those_found {
    use super::{EffectReport, MAX_CLAIMED};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(effects: &[EffectReport; MAX_CLAIMED], serializer: S) -> Result<S::Ok, S::Error> {
        let count = effects.iter().take_while(|effect| **effect != EffectReport::default()).count();
        effects.get(..count).unwrap_or_default().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[EffectReport; MAX_CLAIMED], D::Error> {
        let found = heapless::Vec::<EffectReport, MAX_CLAIMED>::deserialize(deserializer)?;
        let mut effects = [EffectReport::default(); MAX_CLAIMED];
        effects.iter_mut().zip(found).for_each(|(effect, found)| *effect = found);
        Ok(effects)
    }
}

/// What is to be thought of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Verdict {
    /// The tool moved too little, or too little could be read, to tell. The first, so that its tag is zero in a static.
    NotEnoughExcitation,
    /// No effect shows, and what is left is noise.
    ModelSufficient,
    /// Effects were found, and what is left is noise.
    EffectsFound,
    /// More is left than noise.
    UnexplainedResidual,
}
