//! What effects and magnets that have been found take out of a sample's readings.

use super::Probe;
use crate::{
    compensation::{GyroModel, Moment, effect::REFERENCE_TEMPERATURE_C},
    magnet::FieldUse,
    sample::{Reading, Sample, SampleFlags},
};
use nalgebra::Vector3;

/// Over how long the shaking is averaged, seconds.
const SHAKING_S: f32 = 0.2;

impl Probe {
    /// Before a sample is compensated: an update that is due takes effect, the gyro's model and what is taken out with it.
    pub(super) fn take_effect(&mut self, t_us: u64) {
        let before = self.model_here();
        let Some(taken) = self.identifier.take_effect(t_us, &self.config) else { return };
        if taken.effects {
            self.attitude_effects = self.effects().of_attitude(self.library());
        }
        if taken.is_window || self.mag_delay_sigma_s().is_none() {
            // What was found a moment ago is not yet what a heading is to hang on.
            self.filter.mag_delay_known(self.mag_delay_sigma_s());
        }
        if taken.of_field {
            self.filter.field_changed();
        }
        let after = self.model_here();
        self.filter.model_changed(&before, &after, &taken.sigma);
    }

    /// The gyro's model with what its effects add while the probe stands still here: the bias that it reads.
    fn model_here(&self) -> GyroModel {
        let flown = *self.identifier.flown();
        let mut still = Moment {
            rate_rad_s: Vector3::zeros(),
            acceleration_rad_s2: Vector3::zeros(),
            force_m_s2: self.last_force_m_s2,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: Vector3::zeros(),
            warming_k: self.last_warming_k,
        };
        self.attitude_effects.correct_rate(self.library(), &mut still);
        let added = flown.p_matrix().try_inverse().map_or(still.rate_rad_s, |inverse| inverse * still.rate_rad_s);
        GyroModel { b_rad_s: (Vector3::from(flown.b_rad_s) - added).into(), ..flown }
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
        let warming_k = if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { self.last_warming_k };
        (self.last_force_m_s2, self.last_warming_k) = (force, warming_k);
        let mut moment = Moment {
            rate_rad_s: *rate,
            acceleration_rad_s2: acceleration,
            force_m_s2: force,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: field,
            warming_k,
        };
        self.attitude_effects.correct(self.library(), &mut moment);
        moment
    }

    /// Takes from the calibrated field what a magnet on the probe adds to it; makes it missing while it is not to be believed.
    pub(super) fn watch(&mut self, t_us: u64, [gyro, accel]: [Reading; 2], mag: &mut Reading) {
        if !self.config.effects {
            return;
        }
        self.watch.push(t_us, [gyro, accel, *mag]);
        match (*mag, self.watch.field_use()) {
            (Reading::Good(field), FieldUse::Less(offset)) => *mag = Reading::Good(field - offset),
            (_, FieldUse::Withheld) => *mag = Reading::Missing,
            _ => {}
        }
    }
}
