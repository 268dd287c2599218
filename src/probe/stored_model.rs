//! A model that outlives the power: into the probe before its first sample, and out of it when it is worth a record.

use super::Probe;
use crate::{
    estimator::{Learnt, LearntHead, NotContinued, P_DRIFT},
    identification::WindowReport,
    storage::{Implausible, Limits, StabilityGate, StoredModel},
};

/// Why a stored model does not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum NotRestored {
    /// Only a probe that has been configured and has taken no sample can take a model.
    NotAtTheBeginning,
    /// Its bias goes with its effects, and the configuration switches effects off.
    EffectsSwitchedOff,
    /// It may not fly with this configuration and library.
    Implausible(Implausible),
}

impl Probe {
    /// Flies a stored model from the first sample on, instead of the factory's. Call it after [`Probe::configure`]; P's prior
    /// is then about it, and what the samples say takes its place once there is enough motion.
    ///
    /// # Errors
    /// The model does not fly, and the probe is as it was.
    pub fn restore(&mut self, model: &StoredModel) -> Result<(), NotRestored> {
        if !self.configured || self.counters.samples > 0 {
            return Err(NotRestored::NotAtTheBeginning);
        }
        self.may_restore(model)?;
        self.identifier.restore(&model.gyro, &model.sigma, &model.effects);
        self.attitude_effects = self.effects().of_attitude(self.library());
        self.filter.mag_delay_known(self.mag_delay_sigma_s());
        if model.gyro.p != self.config.gyro.p {
            // P is as well known as when it was stored, but for its drift. A bias is another one at every start: it is as unknown as without
            // a record.
            let mut sigma = model.sigma.map(|sigma| libm::sqrtf(sigma * sigma + P_DRIFT * P_DRIFT));
            sigma.iter_mut().skip(9).for_each(|sigma| *sigma = f32::MAX);
            self.filter.model_changed(&self.config.gyro, &model.gyro, &sigma);
        }
        self.last_raw_rad_s = model.gyro.b_rad_s;
        Ok(())
    }

    /// What the filter has learnt of gyro, accelerometer and magnetometer, to be stored beside the model; `None` for a moment while it is
    /// updated. It stays as it is until the next [`Probe::poll`].
    #[must_use]
    pub fn learnt(&self) -> Option<Learnt<'_>> {
        self.identifier.learnt(&self.config)
    }

    /// Has the filter go on from what it had learnt of accelerometer and magnetometer when a model was stored, but for the drift of the time
    /// without power, and count the motion of then. Call it after [`Probe::restore`] of that model. `read` hands out all
    /// [`NUMBERS`](crate::estimator::NUMBERS) numbers and returns whether it could.
    ///
    /// # Errors
    /// The filter starts without; what flies is as it was.
    pub fn go_on(
        &mut self,
        head: &LearntHead,
        read: impl FnOnce(&mut dyn FnMut(usize, f32)) -> bool,
    ) -> Result<(), NotContinued> {
        if !self.configured || self.counters.samples > 0 {
            return Err(NotContinued::NotAtTheBeginning);
        }
        self.identifier.go_on(head, &self.config, read)
    }

    /// Whether a model may fly with this configuration and library.
    ///
    /// # Errors
    /// Why not.
    pub fn may_restore(&self, model: &StoredModel) -> Result<(), NotRestored> {
        if !self.config.effects && !model.effects.is_empty() {
            return Err(NotRestored::EffectsSwitchedOff);
        }
        Limits::new(&self.config, self.library()).check(model).map_err(NotRestored::Implausible)
    }

    /// Starts afresh from the configuration that there is, as after power-up: with a model that is restored, or the factory's. All that
    /// was learnt from the samples so far is forgotten; counters begin anew.
    ///
    /// # Errors
    /// The model does not fly, and the probe is as it was.
    pub fn restart(&mut self, model: Option<&StoredModel>) -> Result<(), NotRestored> {
        model.map_or(Ok(()), |model| self.may_restore(model))?;
        let config = self.config;
        self.configure(&config).map_err(|_| NotRestored::NotAtTheBeginning)?;
        model.map_or(Ok(()), |model| self.restore(model))
    }

    /// The model that flies, where it is worth a record; to be asked with every report that [`Probe::poll`] hands out.
    pub fn model_worth_storing(&self, report: &WindowReport, gate: &mut StabilityGate) -> Option<StoredModel> {
        gate.window(report, self.gyro_model(), self.effects(), self.library())
    }
}
