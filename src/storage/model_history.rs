//! History of models that commands can ask for: the flown one, the one before, and the fit of the latest window.

use super::{StoreReason, StoredModel, fingerprint, stability::agrees};
use crate::{
    compensation::{ActiveEffects, Effect, GyroModel},
    config::Config,
    identification::{Decision, WindowReport},
};

/// Models that a command can ask for, as they would be stored on a command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelHistory {
    /// Model at the end of the latest window.
    flying: StoredModel,
    previous: Option<StoredModel>,
    proposal: Option<Proposal>,
}

/// Fit of a window, beside the effects that flew then.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Proposal {
    window_end_us: u64,
    gyro: GyroModel,
    sigma: [f32; 12],
}

impl ModelHistory {
    /// History of a probe that starts afresh with this model; `previous` flew before. `library` is the [`fingerprint`]
    /// of what effects are relative to from now on, which a model without effects need not have.
    #[must_use]
    pub const fn new(flying: &StoredModel, library: u32, previous: Option<StoredModel>) -> Self {
        Self { flying: StoredModel { library, reason: StoreReason::Command, ..*flying }, previous, proposal: None }
    }

    /// History of a probe that starts with the factory's model of this configuration.
    #[must_use]
    pub fn of_factory(config: &Config, library: &[&dyn Effect]) -> Self {
        let flying = StoredModel {
            gyro: config.gyro,
            sigma: [0.0; 12],
            effects: ActiveEffects::none(),
            library: fingerprint(library, config),
            temperature_c: None,
            t_us: 0,
            reason: StoreReason::Command,
        };
        Self { flying, previous: None, proposal: None }
    }

    /// Takes a window's report once it has taken effect, with the flown model and the temperatures that it comes
    /// from.
    pub fn window(
        &mut self,
        report: &WindowReport,
        gyro: &GyroModel,
        effects: &ActiveEffects,
        temperature_c: Option<[f32; 2]>,
    ) {
        let flying = &mut self.flying;
        // A change of the bias alone, as with temperature, does not make another model.
        let indices = |effects: &ActiveEffects| effects.iter().fold(1, |all, found| all << 4 | u64::from(found.index));
        if flying.gyro.p != gyro.p || indices(&flying.effects) != indices(effects) {
            self.previous = Some(*flying);
        }
        if flying.effects != *effects {
            self.proposal = None;
        }
        flying.gyro = *gyro;
        flying.effects = *effects;
        flying.temperature_c = temperature_c;
        flying.t_us = report.t_end_us;
        let WindowReport { fitted, sigma, .. } = *report;
        let mut proposal = Proposal { window_end_us: report.t_end_us, gyro: fitted, sigma };
        if report.decision == Decision::Accepted {
            flying.sigma = sigma;
            proposal.gyro = *gyro;
        }
        if agrees(report.decision).is_some() {
            self.proposal = Some(proposal);
        }
    }

    /// Returns the fit of a window, accepted or not. `None` if it is not the latest window that could judge, or effects
    /// have changed since. A window with too little motion, with sensors that cannot judge or with an overrun could
    /// not: the fit before it stays.
    #[must_use]
    pub fn proposed(&self, window_end_us: u64, effects: &ActiveEffects) -> Option<StoredModel> {
        let proposal = self.proposal.filter(|_| self.flying.effects == *effects);
        let proposal = proposal.filter(|proposal| proposal.window_end_us == window_end_us)?;
        let Proposal { gyro, sigma, .. } = proposal;
        Some(StoredModel { gyro, sigma, t_us: window_end_us, ..self.flying })
    }

    /// Returns the model that flew before the latest change of P or of the list of effects; `None` before the first
    /// change of this history.
    #[must_use]
    pub const fn previous(&self) -> Option<&StoredModel> {
        self.previous.as_ref()
    }

    /// Returns the model at the end of the latest window.
    #[must_use]
    pub const fn latest(&self) -> &StoredModel {
        &self.flying
    }

    /// Returns the flown model, with this gyro model and these effects by now.
    #[must_use]
    pub fn flying(&self, gyro: &GyroModel, effects: &ActiveEffects) -> StoredModel {
        StoredModel { gyro: *gyro, effects: *effects, ..self.flying }
    }
}
