//! Models that were stored to their end: a start restores one of these, and no other.

use super::chip::{Flash, SECTORS};
use meerkat_mwd::{
    Config,
    compensation::{ActiveEffects, GyroModel, effects::LIBRARY},
    storage::{Limits, ModelStore, Outcome},
};

/// P, b and effects of each model of which the program reported that it was stored, and of each whose last word was
/// being programmed when the power failed.
#[derive(Default)]
pub struct Completed(Vec<(GyroModel, ActiveEffects)>);

impl Completed {
    /// Takes note of the newest model in a flash, and of the one before it where two were stored in one round of the
    /// program. The flash is that of the moment, which nothing has damaged since.
    pub fn note(&mut self, flash: &Flash, config: &Config, models: u32) {
        let mut flash = flash.clone();
        flash.power_up();
        let Ok(mut store) = ModelStore::<_, SECTORS>::open(flash, Limits::new(config, &LIBRARY)) else { return };
        let Ok(Outcome::Chosen { model, number, .. }) = store.restore(None).map(|found| found.outcome) else { return };
        let before = (models > 1).then(|| store.model_before(number).ok().flatten()).flatten();
        for model in [Some(model), before].into_iter().flatten() {
            if !self.has(&model.gyro, &model.effects) {
                self.0.push((model.gyro, model.effects));
            }
        }
    }

    /// Returns true if a model with these was stored to its end.
    pub fn has(&self, gyro: &GyroModel, effects: &ActiveEffects) -> bool {
        self.0.contains(&(*gyro, *effects))
    }
}
