//! Correction of a sample's readings by the effects and magnets that were found.

use super::Probe;
use crate::{
    compensation::{GyroModel, Snapshot, effect::REFERENCE_TEMPERATURE_C},
    magnet::FieldUse,
    sample::{Reading, Sample, SampleFlags},
};
use nalgebra::Vector3;

/// Averaging time of the squared force, seconds.
const SHAKING_S: f32 = 0.2;

impl Probe {
    /// Lets an update that is due take effect before a sample is compensated: the gyro model, and the effects
    /// with it.
    pub(super) fn take_effect(&mut self, t_us: u64) {
        let before = self.model_here();
        let Some(taken) = self.identifier.take_effect(t_us, &self.config) else { return };
        if taken.effects {
            self.session.attitude_effects = self.effects().of_attitude(self.library());
        }
        if taken.is_window || self.mag_delay_sigma_s().is_none() {
            // A heading must not depend yet on a delay found a moment ago.
            self.filter.mag_delay_known(self.mag_delay_sigma_s());
        }
        if taken.of_field {
            self.filter.field_changed();
        }
        let after = self.model_here();
        self.filter.model_changed(&before, &after, &taken.sigma);
    }

    /// Gyro model with the bias that its effects add at the present force and temperature while the probe
    /// stands still.
    fn model_here(&self) -> GyroModel {
        let flown = *self.identifier.flown();
        let mut still = Snapshot {
            rate_rad_s: Vector3::zeros(),
            acceleration_rad_s2: Vector3::zeros(),
            force_m_s2: self.session.last_force_m_s2,
            square_force_m2_s4: self.session.square_force_m2_s4,
            field_ut: Vector3::zeros(),
            warming_k: self.session.last_warming_k,
        };
        self.session.attitude_effects.correct_rate(self.library(), &mut still);
        let added = flown.p_matrix().try_inverse().map_or(still.rate_rad_s, |inverse| inverse * still.rate_rad_s);
        GyroModel { b_rad_s: (Vector3::from(flown.b_rad_s) - added).into(), ..flown }
    }

    /// Returns the sample's readings corrected by the effects that were found.
    pub(super) fn corrected(
        &mut self,
        sample: &Sample,
        rate: &Vector3<f32>,
        [accel, mag]: [Reading; 2],
        step_s: f32,
    ) -> Snapshot {
        let reading = |reading: Reading| if let Reading::Usable(v) = reading { v } else { Vector3::zeros() };
        let (force, field) = (reading(accel), reading(mag));
        let acceleration = match self.session.last_rate_rad_s {
            Some(last) if step_s > 0.0 => (rate - last) / step_s,
            _ => Vector3::zeros(),
        };
        self.session.last_rate_rad_s = Some(*rate);
        if let Reading::Usable(force) = accel {
            let share = step_s / SHAKING_S;
            self.session.square_force_m2_s4 +=
                (force.norm_squared() - self.session.square_force_m2_s4) * if share < 1.0 { share } else { 1.0 };
        }
        let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        let warming_k = if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { self.session.last_warming_k };
        (self.session.last_force_m_s2, self.session.last_warming_k) = (force, warming_k);
        let mut moment = Snapshot {
            rate_rad_s: *rate,
            acceleration_rad_s2: acceleration,
            force_m_s2: force,
            square_force_m2_s4: self.session.square_force_m2_s4,
            field_ut: field,
            warming_k,
        };
        self.session.attitude_effects.correct(self.library(), &mut moment);
        moment
    }

    /// Subtracts a magnet's field from the calibrated field; withholds the field while the magnet is
    /// undecided.
    pub(super) fn watch(&mut self, t_us: u64, [gyro, accel]: [Reading; 2], mag: &mut Reading) {
        if !self.config.effects {
            return;
        }
        self.watch.push(t_us, [gyro, accel, *mag]);
        match (*mag, self.watch.field_use()) {
            (Reading::Usable(field), FieldUse::Less(offset)) => *mag = Reading::Usable(field - offset),
            (_, FieldUse::Withheld) => *mag = Reading::Missing,
            _ => {}
        }
    }
}
