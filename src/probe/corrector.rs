//! Correction of a sample's readings by the effects that were found.

use crate::{
    compensation::{ActiveEffects, Effect, GyroModel, Snapshot, effect::REFERENCE_TEMPERATURE_C},
    config::Config,
    estimator::turned_back,
    rotation::{exp_quaternion, rotate_back},
    sample::{Reading, Sample, SampleFlags},
};
use nalgebra::Vector3;

/// Averaging time of the squared force, seconds.
const SHAKING_S: f32 = 0.2;

/// Terms that are taken out of the readings before the attitude filter.
pub(super) trait TakenOut {
    /// All-zero value for a static before it is configured.
    const ZERO: Self;

    /// Forgets what was taken out, and starts from a configuration.
    fn start(&mut self, config: &Config);

    /// Takes it out of a sample's readings; `rate` and `acceleration` are the compensated ones, rad/s and rad/s^2.
    fn correct(
        &mut self,
        library: &[&dyn Effect],
        sample: &Sample,
        motion: [&Vector3<f32>; 2],
        vectors: [Reading; 2],
        step_s: f32,
    ) -> Snapshot;

    /// Variances on each axis of what is taken out of force and field at the last sample, whose corrected readings are
    /// given, rad/s, m/s^2 and microtesla.
    fn vector_variances(&self, library: &[&dyn Effect], readings: [Vector3<f32>; 3]) -> [Vector3<f32>; 2];
}

/// Nothing is taken out: for a probe that looks for no effects, and has no memory for them.
pub(super) struct Nothing;

impl TakenOut for Nothing {
    const ZERO: Self = Self;

    fn start(&mut self, _config: &Config) {}

    fn correct(
        &mut self,
        _library: &[&dyn Effect],
        _sample: &Sample,
        [rate, acceleration]: [&Vector3<f32>; 2],
        [accel, mag]: [Reading; 2],
        _step_s: f32,
    ) -> Snapshot {
        Snapshot {
            rate_rad_s: *rate,
            acceleration_rad_s2: *acceleration,
            force_m_s2: value(accel),
            square_force_m2_s4: 0.0,
            field_ut: value(mag),
            warming_k: 0.0,
        }
    }

    fn vector_variances(&self, _library: &[&dyn Effect], _readings: [Vector3<f32>; 3]) -> [Vector3<f32>; 2] {
        [Vector3::zeros(); 2]
    }
}

/// Effects that were found, and what their terms depend on.
pub(super) struct Found {
    pub effects: ActiveEffects,
    square_force_m2_s4: f32,
    /// Last usable specific force, turned back as the probe turned since, and below it the last temperature above the
    /// effects' reference, kelvin.
    last_force_m_s2: Vector3<f32>,
    last_warming_k: f32,
}

impl TakenOut for Found {
    const ZERO: Self = Self {
        effects: ActiveEffects::none(),
        square_force_m2_s4: 0.0,
        last_force_m_s2: Vector3::new(0.0, 0.0, 0.0),
        last_warming_k: 0.0,
    };

    /// The mean squared force starts at that of gravity.
    fn start(&mut self, config: &Config) {
        let gravity = config.earth.gravity_m_s2;
        *self = Self { square_force_m2_s4: gravity * gravity, ..Self::ZERO };
    }

    fn correct(
        &mut self,
        library: &[&dyn Effect],
        sample: &Sample,
        [rate, acceleration]: [&Vector3<f32>; 2],
        [accel, mag]: [Reading; 2],
        step_s: f32,
    ) -> Snapshot {
        if let Reading::Usable(force) = accel {
            let share = step_s / SHAKING_S;
            self.square_force_m2_s4 +=
                (force.norm_squared() - self.square_force_m2_s4) * if share < 1.0 { share } else { 1.0 };
            self.last_force_m_s2 = force;
        } else {
            self.last_force_m_s2 = rotate_back(&exp_quaternion(&(rate * step_s)), &self.last_force_m_s2);
        }
        let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
        self.last_warming_k = if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { self.last_warming_k };
        let mut snapshot = Snapshot {
            rate_rad_s: *rate,
            acceleration_rad_s2: *acceleration,
            force_m_s2: self.last_force_m_s2,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: value(mag),
            warming_k: self.last_warming_k,
        };
        self.effects.correct(library, &mut snapshot);
        snapshot
    }

    // Not inlined: its stack frame would else lie under that of the surveys.
    #[inline(never)]
    fn vector_variances(&self, library: &[&dyn Effect], readings: [Vector3<f32>; 3]) -> [Vector3<f32>; 2] {
        if self.effects.is_empty() {
            return [Vector3::zeros(); 2];
        }
        let [rate_rad_s, force_m_s2, field_ut] = readings;
        let snapshot = Snapshot {
            rate_rad_s,
            acceleration_rad_s2: Vector3::zeros(),
            force_m_s2,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut,
            warming_k: self.last_warming_k,
        };
        self.effects.vector_variances(library, &snapshot)
    }
}

impl Found {
    /// Gyro model with the bias that the effects add to it at the present force and temperature while the
    /// probe stands still.
    pub fn model_here(&self, flown: &GyroModel, library: &[&dyn Effect]) -> GyroModel {
        let mut still = Snapshot {
            rate_rad_s: Vector3::zeros(),
            acceleration_rad_s2: Vector3::zeros(),
            force_m_s2: self.last_force_m_s2,
            square_force_m2_s4: self.square_force_m2_s4,
            field_ut: Vector3::zeros(),
            warming_k: self.last_warming_k,
        };
        self.effects.correct_rate(library, &mut still);
        let added = turned_back(flown, &still.rate_rad_s);
        GyroModel { b_rad_s: (Vector3::from(flown.b_rad_s) - added).into(), ..*flown }
    }
}

fn value(reading: Reading) -> Vector3<f32> {
    if let Reading::Usable(v) = reading { v } else { Vector3::zeros() }
}

/// Terms that are taken out of the readings, and the rate of the previous sample.
pub(super) struct Corrector<T> {
    pub taken_out: T,
    /// Rate of the previous sample before it was compensated.
    last_raw_rad_s: Option<Vector3<f32>>,
}

impl<T: TakenOut> Corrector<T> {
    /// All-zero value for a static before it is configured.
    pub const ZERO: Self = Self { taken_out: T::ZERO, last_raw_rad_s: None };

    /// Starts without effects.
    pub fn start(&mut self, config: &Config) {
        self.taken_out.start(config);
        self.last_raw_rad_s = None;
    }

    /// Rate of the previous sample, compensated by the present model; at the first sample `rate_rad_s`. When the model
    /// has changed, the step from one to the other is thus no angular acceleration.
    pub fn rate_before(&self, model: &GyroModel, rate_rad_s: Vector3<f32>) -> Vector3<f32> {
        self.last_raw_rad_s.map_or(rate_rad_s, |raw| model.compensate(raw.into()))
    }

    /// Returns the sample's readings corrected by the effects; `raw` is its rate before it was compensated, and
    /// `motion` its compensated rate, rad/s, and the angular acceleration up to it, rad/s^2.
    pub fn correct(
        &mut self,
        library: &[&dyn Effect],
        sample: &Sample,
        (raw, motion): (Vector3<f32>, [&Vector3<f32>; 2]),
        vectors: [Reading; 2],
        step_s: f32,
    ) -> Snapshot {
        self.last_raw_rad_s = Some(raw);
        self.taken_out.correct(library, sample, motion, vectors, step_s)
    }
}

#[cfg(test)]
mod tests;
