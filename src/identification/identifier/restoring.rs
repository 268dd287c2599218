//! A model from an earlier session.

use super::Identifier;
use crate::compensation::{ActiveEffects, GyroModel};

impl Identifier {
    /// Flies this model from the first sample on; call it between `configure` and `start`.
    pub fn restore(&mut self, gyro: &GyroModel, effects: &ActiveEffects) {
        self.flown = *gyro;
        self.stream.set_effects(effects);
    }
}
