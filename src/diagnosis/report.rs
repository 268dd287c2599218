use super::remainder::RemainderReport;
use crate::compensation::{ActiveEffects, FoundEffect, GyroModel, MAX_ACTIVE};
use nalgebra::Vector3;

/// Most candidates of a library.
pub const MAX_CANDIDATES: usize = 24;

/// What came of one diagnosis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DiagnosisReport {
    /// Beginning of the samples looked at, microseconds.
    pub t_start_us: u64,
    /// Their end.
    pub t_end_us: u64,
    /// First sample from which the effects are taken out, microseconds.
    pub t_effect_us: u64,
    /// What is to be thought of the model.
    pub verdict: Verdict,
    /// The effects found.
    pub effects: [EffectReport; MAX_ACTIVE],
    /// How many there are.
    pub count: u8,
    /// When the gyro's bias stepped and what it is since, where that effect was found.
    pub bias_step: Option<BiasStepReport>,
    /// Every candidate as it stood when the last was chosen.
    pub tried: [Tried; MAX_CANDIDATES],
    /// How many there are.
    pub candidates: u8,
    /// By how much the gyro's bias is another one with these effects than without, rad/s: the constant part of what they add to its
    /// reading.
    pub bias_change_rad_s: [f32; 3],
    /// Residual of gravity's and of the field's rows with the gyro's parameters alone: angle, radians rms.
    pub residual_before_rad: [f32; 2],
    /// The same with the effects.
    pub residual_after_rad: [f32; 2],
    /// Mean square of the field's residual in units of its white noise, before and after (normalised innovation squared).
    pub nis: [f32; 2],
    /// What the field's residual goes with, where more of it is left than can be explained; else nothing is said.
    pub remainder: RemainderReport,
}

impl DiagnosisReport {
    /// Whether it says anything about the effects: with too little motion those that are known stay.
    #[must_use]
    pub fn is_conclusive(&self) -> bool {
        self.verdict != Verdict::NotEnoughExcitation
    }

    /// The effects found.
    pub fn found(&self) -> impl Iterator<Item = &EffectReport> {
        self.effects.iter().take(usize::from(self.count))
    }

    /// Those of them that are taken out; a step of the bias is not: the bias that flies is moved.
    #[must_use]
    pub fn active(&self) -> ActiveEffects {
        let mut active = ActiveEffects::none();
        for effect in self.found().filter(|effect| effect.believed && !self.is_bias_step(effect)) {
            active.add(effect.found);
        }
        active
    }
}

impl DiagnosisReport {
    fn is_bias_step(&self, effect: &EffectReport) -> bool {
        self.bias_step.is_some_and(|step| step.effect == effect.found.index)
    }

    /// The step of the bias that is to be followed, and by how much, compensated frame, rad/s.
    pub(crate) fn believed_step(&self) -> Option<(BiasStepReport, Vector3<f32>)> {
        let found = self.found().find(|effect| effect.believed && self.is_bias_step(effect))?;
        let [x, y, z, ..] = found.found.parameters;
        self.bias_step.map(|step| (step, Vector3::new(x, y, z)))
    }
}

/// A step of the gyro's bias.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BiasStepReport {
    /// Its place in the library.
    pub effect: u8,
    /// When it was, microseconds: at a shock, to a tenth of a second.
    pub t_us: u64,
    /// First increment after it.
    pub(crate) until: u32,
    /// Mean raw rate of the samples looked at, rad/s, as if the bias had been the new one all along, and the mean rate that it stands for:
    /// they tell the bias for whatever P.
    pub(crate) raw_rad_s: [f32; 3],
    pub(crate) rate_rad_s: [f32; 3],
}

impl BiasStepReport {
    /// The bias after it with the P of a model, raw frame, rad/s.
    #[must_use]
    pub fn bias_rad_s(&self, model: &GyroModel) -> Option<[f32; 3]> {
        let turned = model.p_matrix().try_inverse()? * Vector3::from(self.rate_rad_s);
        Some((Vector3::from(self.raw_rad_s) - turned).into())
    }
}

/// An effect that was found.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EffectReport {
    /// Which, and how large.
    pub found: FoundEffect,
    /// Gain in log-likelihood when it was chosen.
    pub evidence: f32,
    /// Chance of as clear a show without it.
    pub p_value: f32,
    /// How much it turns its sensor's vector, or the gyro's rotation over a second: radians rms.
    pub size_rad: f32,
    /// What the deviations of its parameters alone would turn: radians rms.
    pub size_sigma_rad: f32,
    /// Residual of the vector that shows it most, radians rms, before it was chosen and after.
    pub residual_rad: [f32; 2],
    /// Whether its parameters are in the range that is believed, enough of it is seen, and P does not have it in: else it is named, and not taken
    /// out.
    pub believed: bool,
}

/// How a candidate that was not chosen stood.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tried {
    /// Gain in log-likelihood that it would have given.
    pub evidence: f32,
    /// Chance of as clear a show without it; 1 where it could not be tried.
    pub p_value: f32,
    /// Whether it was dropped for being too small to matter.
    pub too_small: bool,
    /// Whether it would have been found, were the field's residual explained: it may be the unknown effect's.
    pub suspected: bool,
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
    /// Effects were found, and what is left is small.
    EffectsFound,
    /// More is left than noise and than matters little.
    UnexplainedResidual,
}
