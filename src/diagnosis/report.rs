//! Report of a diagnosis: verdict, effects with their evidence, and the remainder. One is made when a window closes.

use crate::{
    compensation::{ActiveEffects, FoundEffect},
    estimator::{MAX_CANDIDATES, MAX_CLAIMED, RemainderReport},
};

/// Estimator's evidence for the effects when a window closed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiagnosisReport {
    /// Beginning of the window, microseconds. The evidence is from all samples since the estimator began.
    pub t_start_us: u64,
    /// End of the window, microseconds.
    pub t_end_us: u64,
    /// First sample from which these effects are taken out, microseconds.
    pub t_effect_us: u64,
    /// Verdict on the model.
    pub verdict: Verdict,
    /// The effects found.
    #[cfg_attr(feature = "serde", serde(with = "those_found"))]
    pub effects: [EffectReport; MAX_CLAIMED],
    /// Number of effects found.
    pub count: u8,
    /// Log Bayes factor of every candidate beside the effects found: the library's effects in its order, then further
    /// steps of the bias. It is 0 for a candidate that could not be tried or is among those found.
    pub tried: [f32; MAX_CANDIDATES],
    /// Number of candidates.
    pub candidates: u8,
    /// Mean squared innovation over its degrees of freedom with the gyro's parameters alone, and with all effects
    /// found.
    pub nis: [f32; 2],
    /// Quantities that the field's innovations vary with; empty if only noise is left.
    pub remainder: RemainderReport,
}

impl DiagnosisReport {
    /// Returns true if the report says anything about the effects.
    #[must_use]
    pub fn is_conclusive(&self) -> bool {
        self.verdict != Verdict::NotEnoughExcitation
    }

    /// Returns the effects found.
    pub fn found(&self) -> impl Iterator<Item = &EffectReport> {
        self.effects.iter().take(usize::from(self.count))
    }

    /// Returns the effects that are taken out. A step of the bias is not among them: the flown bias includes it.
    #[must_use]
    pub fn active(&self) -> ActiveEffects {
        let mut active = ActiveEffects::none();
        for effect in self.found().filter(|effect| effect.is_taken_out() && effect.step_us == 0) {
            active.add(effect.found);
        }
        active
    }
}

/// Effect that was found.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EffectReport {
    /// Effect by its index in the library, with parameters and their deviations.
    pub found: FoundEffect,
    /// Log Bayes factor for this effect, beside the others that were found.
    pub evidence: f32,
    /// Size of the effect as a turn of its sensor's vector, or of the gyro's rotation over a second: radians rms.
    pub size_rad: f32,
    /// Size, in the same way, of the deviations of its parameters alone: radians rms.
    pub size_sigma_rad: f32,
    /// Other effects of the library that are as likely, one bit each: with these sensors and this motion they cannot
    /// be told apart.
    pub rivals: u32,
    /// Time of a step of the bias, microseconds; 0 for other effects.
    pub step_us: u64,
    /// Time since when the effect is found without a break, microseconds.
    pub found_us: u64,
    /// Time since when the effect is taken out, microseconds; 0 if it is not, as when it is larger than believable.
    pub taken_out_us: u64,
}

impl EffectReport {
    /// Returns true if the effect is taken out.
    #[must_use]
    pub const fn is_taken_out(&self) -> bool {
        self.taken_out_us > 0
    }
}

/// Serialises only the effects that were found: the other entries are empty, and a serial line is slow.
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

/// Verdict on the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Verdict {
    /// Too little motion for a verdict, or too few readings of it. It stands first so that its tag is zero in a static.
    NotEnoughExcitation,
    /// No effect shows, and only noise is left.
    ModelSufficient,
    /// Effects were found, and only noise is left.
    EffectsFound,
    /// More than noise is left.
    UnexplainedResidual,
}
