//! Restoration of a stored model before the first sample, and the model worth storing.

use super::Probe;
use crate::{
    compensation::{Effect, effects::LIBRARY},
    estimator::{Learnt, LearntHead, NotContinued, P_DRIFT},
    identification::WindowReport,
    storage::{Implausible, Limits, StabilityGate, StoredModel, fingerprint},
};

/// Reason for which a stored model does not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum NotRestored {
    /// The probe is not configured, or has already taken a sample or a model.
    NotAtTheBeginning,
    /// The configuration switches off the effects that belong to the stored bias.
    EffectsSwitchedOff,
    /// The model is outside the limits of this configuration, or its effects are relative to another one.
    Implausible(Implausible),
}

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Probe<NODES, COLUMNS, REPORTS> {
    /// Flies a stored model from the first sample on, instead of the factory's. Call it after
    /// [`Probe::configure`]. P's prior is then centred on the model, and the samples take over as soon as
    /// there is enough motion.
    ///
    /// # Errors
    /// States why the model does not fly; the probe stays as it was.
    pub fn restore(&mut self, model: &StoredModel) -> Result<(), NotRestored> {
        if !self.configured || self.session.counters.samples > 0 || self.session.is_restored {
            return Err(NotRestored::NotAtTheBeginning);
        }
        self.may_restore(model)?;
        self.session.is_restored = true;
        self.identifier.restore(&self.config, &model.gyro, &model.sigma, &model.effects);
        self.pipeline.corrector.taken_out.effects = self.effects().of_attitude(self.library());
        self.pipeline.filter.mag_delay_known(self.mag_delay_sigma_s());
        if model.gyro.p != self.config.gyro.p {
            // P is as certain as when it was stored, apart from its drift since. The bias changes at every start: it is
            // unknown.
            let mut sigma = model.sigma.map(|sigma| libm::sqrtf(sigma * sigma + P_DRIFT * P_DRIFT));
            sigma.iter_mut().skip(9).for_each(|sigma| *sigma = f32::MAX);
            self.pipeline.filter.model_changed(&self.config.gyro, &model.gyro, &sigma);
        }
        self.pipeline.last_raw_rad_s = model.gyro.b_rad_s;
        Ok(())
    }

    /// Returns what the estimator has learnt of gyro, accelerometer and magnetometer, to store beside the model; `None`
    /// for a moment while the estimator is updated. The result stays unchanged until the next [`Probe::poll`].
    #[must_use]
    pub fn learnt(&self) -> Option<Learnt<'_>> {
        self.identifier.learnt(&self.config)
    }

    /// Continues from what the estimator had learnt of accelerometer and magnetometer when a model was stored, inflated
    /// by the drift of the time without power; the motion learnt from until then counts, too. Call it after
    /// [`Probe::restore`] of that model. `read` hands out all [`NUMBERS`](crate::estimator::NUMBERS) numbers and
    /// returns true if it could.
    ///
    /// # Errors
    /// States why it cannot continue: the estimator starts from its prior, and the flown model stays.
    pub fn go_on(
        &mut self,
        head: &LearntHead,
        read: impl FnOnce(&mut dyn FnMut(usize, f32)) -> bool,
    ) -> Result<(), NotContinued> {
        if !self.configured || self.session.counters.samples > 0 {
            return Err(NotContinued::NotAtTheBeginning);
        }
        self.identifier.go_on(head, &self.config, read)
    }

    /// Checks that a model may fly with this configuration and library.
    ///
    /// # Errors
    /// States why it may not.
    pub fn may_restore(&self, model: &StoredModel) -> Result<(), NotRestored> {
        self.may_restore_with(self.library(), model)
    }

    fn may_restore_with(
        &self,
        library: &'static [&'static dyn Effect],
        model: &StoredModel,
    ) -> Result<(), NotRestored> {
        if !self.config.effects && !model.effects.is_empty() {
            return Err(NotRestored::EffectsSwitchedOff);
        }
        Limits::new(&self.config, library).check(model).map_err(NotRestored::Implausible)
    }

    /// Starts anew from the present configuration, as after power-up, with the given model or the factory's.
    /// All that was learnt from samples is forgotten; the counters start at zero.
    ///
    /// # Errors
    /// States why the model does not fly; the probe stays as it was.
    pub fn restart(&mut self, model: Option<&StoredModel>) -> Result<(), NotRestored> {
        let next_library = self.next_library.unwrap_or(&LIBRARY);
        model.map_or(Ok(()), |model| self.may_restore_with(next_library, model))?;
        let config = self.config;
        self.configure(&config).map_err(|_| NotRestored::NotAtTheBeginning)?;
        model.map_or(Ok(()), |model| self.restore(model))
    }

    /// Returns the flown model if it is worth storing. Call it with every report of [`Probe::poll`].
    pub fn model_worth_storing(&self, report: &WindowReport, gate: &mut StabilityGate) -> Option<StoredModel> {
        gate.window(report, self.gyro_model(), self.effects(), fingerprint(self.library(), &self.config))
    }
}
