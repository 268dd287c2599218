//! What effects and magnets that have been found take out of a sample's readings.

use super::Probe;
use crate::{
    compensation::{Moment, effect::REFERENCE_TEMPERATURE_C},
    diagnosis::FieldUse,
    sample::{Reading, Sample, SampleFlags},
};
use nalgebra::Vector3;

/// Over how long the shaking is averaged, seconds; as the diagnosis does.
const SHAKING_S: f32 = 0.2;

impl Probe {
    /// Before a sample is compensated: a diagnosis that is due takes effect, and with it the bias that goes with it. Not while an update is
    /// under way. Returns whether the effects changed, and whether the bias stepped.
    pub(super) fn take_diagnosed(&mut self, t_us: u64) -> [bool; 2] {
        if !self.identifier.is_idle() {
            return [false; 2];
        }
        let Some(change) = self.diagnosis.take_effect(t_us, self.identifier.flown()) else { return [false; 2] };
        [change.effects, self.identifier.follow(t_us, &change)]
    }

    /// The sample's readings without the effects that have been found.
    pub(super) fn corrected(
        &mut self,
        sample: &Sample,
        rate: &Vector3<f32>,
        [accel, mag]: [Reading; 2],
        step_s: f32,
    ) -> Moment {
        let reading = |reading: Reading| if let Reading::Good(v) = reading { v } else { Vector3::zeros() };
        let (force, field) = (reading(accel), reading(mag));
        let acceleration = match self.last_rate_rad_s {
            Some(last) if step_s > 0.0 => (rate - last) / step_s,
            _ => Vector3::zeros(),
        };
        self.last_rate_rad_s = Some(*rate);
        if let Reading::Good(force) = accel {
            let share = step_s / SHAKING_S;
            self.square_force_m2_s4 +=
                (force.norm_squared() - self.square_force_m2_s4) * if share < 1.0 { share } else { 1.0 };
        }
        let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let mut moment = Moment {
            rate_rad_s: *rate,
            acceleration_rad_s2: acceleration,
            force_m_s2: force,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: field,
            warming_k: if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { 0.0 },
        };
        self.attitude_effects.correct(self.library(), &mut moment);
        moment
    }

    /// Takes from the calibrated field what a magnet on the probe adds to it; makes it missing while it is not to be believed and
    /// returns whether that is so.
    pub(super) fn watch(&mut self, t_us: u64, gyro: Reading, mag: &mut Reading) -> bool {
        if !self.config.effects {
            return false;
        }
        if let Some((rest_us, bias)) = self.diagnosis.last_rest(t_us) {
            self.watch.rest(rest_us, &bias);
        }
        self.watch.push(t_us, gyro, *mag);
        match (*mag, self.watch.field_use()) {
            (Reading::Good(field), FieldUse::Less(offset)) => {
                *mag = Reading::Good(field - offset);
                false
            }
            (_, FieldUse::Withheld) => {
                *mag = Reading::Missing;
                true
            }
            _ => false,
        }
    }
}
