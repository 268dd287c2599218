//! Correction of readings by the effects that are taken out.

use super::effect::{Effect, MAX_PARAMETERS, Sensor, Snapshot};
use nalgebra::Vector3;

/// Largest number of effects taken out at a time.
pub const MAX_ACTIVE: usize = 8;

/// A found effect of the library, with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoundEffect {
    /// Index in the library.
    pub index: u8,
    /// Parameters, SI (field: microtesla); zero beyond the effect's dimension.
    pub parameters: [f32; MAX_PARAMETERS],
    /// Standard deviations of the parameters.
    pub sigma: [f32; MAX_PARAMETERS],
}

/// Effects that are taken out of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct ActiveEffects {
    found: [FoundEffect; MAX_ACTIVE],
    count: u8,
}

impl ActiveEffects {
    /// Returns an empty set.
    #[must_use]
    pub const fn none() -> Self {
        const NONE: FoundEffect =
            FoundEffect { index: 0, parameters: [0.0; MAX_PARAMETERS], sigma: [0.0; MAX_PARAMETERS] };
        Self { found: [NONE; MAX_ACTIVE], count: 0 }
    }

    /// Adds an effect. Returns `false` if there is no room.
    pub fn add(&mut self, effect: FoundEffect) -> bool {
        let slot = self.found.get_mut(usize::from(self.count));
        let Some(slot) = slot else { return false };
        *slot = effect;
        self.count += 1;
        true
    }

    /// Returns the effects that correct attitude: without the terms that are taken out only in the estimator
    /// ([`Parameter::only_in_estimator`](super::Parameter::only_in_estimator)), and without effects that have no
    /// others.
    #[must_use]
    pub fn of_attitude(&self, library: &[&dyn Effect]) -> Self {
        let mut rest = Self::none();
        for found in self.iter() {
            let mut found = *found;
            let parameters = library.get(usize::from(found.index)).map_or(&[][..], |effect| effect.parameters());
            for (value, parameter) in found.parameters.iter_mut().zip(parameters) {
                if parameter.only_in_estimator {
                    *value = 0.0;
                }
            }
            if found.parameters.iter().any(|value| *value != 0.0) {
                // The new set has room for all effects of the old one.
                rest.add(found);
            }
        }
        rest
    }

    /// Iterates over the effects that are in the set.
    pub fn iter(&self) -> impl Iterator<Item = &FoundEffect> {
        self.found.iter().take(usize::from(self.count))
    }

    /// Returns true if the set is empty.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Takes the effects out of one instant's readings, the gyro's first, because the other terms depend on
    /// the rate.
    pub fn correct(&self, library: &[&dyn Effect], snapshot: &mut Snapshot) {
        if self.is_empty() {
            return;
        }
        self.correct_rate(library, snapshot);
        self.correct_vectors(library, snapshot);
        let delay_s = self.gyro_delay_s(library);
        if delay_s != 0.0 {
            let turn = snapshot.rate_rad_s * delay_s;
            snapshot.force_m_s2 += turn.cross(&snapshot.force_m_s2);
            snapshot.field_ut += turn.cross(&snapshot.field_ut);
        }
    }

    /// Takes the gyro's effects out of the rate.
    pub(crate) fn correct_rate(&self, library: &[&dyn Effect], snapshot: &mut Snapshot) {
        let read = &*snapshot;
        snapshot.rate_rad_s -= self.added_to_rate(library, |_| read);
    }

    /// Rate that the gyro's effects add, each in the moment that `moment` gives for its place in the library.
    pub(crate) fn added_to_rate<'a>(
        &self,
        library: &[&dyn Effect],
        moment: impl Fn(u8) -> &'a Snapshot,
    ) -> Vector3<f32> {
        // A delay of the whole gyro is not taken out of the rate.
        self.iter().fold(Vector3::zeros(), |sum, found| {
            let effect = library.get(usize::from(found.index)).filter(|effect| effect.sensor() == Sensor::Gyro);
            match effect.filter(|effect| effect.gyro_delay_s(&found.parameters) == 0.0) {
                Some(effect) => sum + contribution(*effect, &found.parameters, moment(found.index)),
                None => sum,
            }
        })
    }

    /// Takes the effects of accelerometer and magnetometer out of their vectors. Terms that do not depend on
    /// the vector go first: they do not lag. The other terms are evaluated halfway between the remaining
    /// reading and the truth, which takes a lag out to second order: to 1e-4 at 15 ms and 300 deg/s.
    pub(crate) fn correct_vectors(&self, library: &[&dyn Effect], snapshot: &mut Snapshot) {
        if self.is_empty() {
            return;
        }
        let read = [snapshot.force_m_s2, snapshot.field_ut];
        let added_to = |[force_m_s2, field_ut]: [Vector3<f32>; 2]| {
            self.added_to_vectors(library, &Snapshot { force_m_s2, field_ut, ..*snapshot })
        };
        let less = |[a, b]: [Vector3<f32>; 2], [x, y]: [Vector3<f32>; 2], share: f32| [a - x * share, b - y * share];
        let constant = added_to([Vector3::zeros(); 2]);
        let left = less(read, constant, 1.0);
        let halfway = less(left, less(added_to(left), constant, 1.0), 0.5);
        [snapshot.force_m_s2, snapshot.field_ut] = less(read, added_to(halfway), 1.0);
    }

    /// Sums of what the effects of accelerometer and magnetometer add to their readings.
    fn added_to_vectors(&self, library: &[&dyn Effect], snapshot: &Snapshot) -> [Vector3<f32>; 2] {
        self.sums_of_vectors(library, |effect, found| contribution(effect, &found.parameters, snapshot))
    }

    /// Variances on each axis of what is taken out of force and field, (m/s^2)^2 and microtesla^2, at `snapshot`, which
    /// is corrected; the parameters' errors count as independent.
    pub(crate) fn vector_variances(&self, library: &[&dyn Effect], snapshot: &Snapshot) -> [Vector3<f32>; 2] {
        self.sums_of_vectors(library, |effect, found| {
            let parameters = found.parameters.iter().zip(&found.sigma).enumerate().take(effect.parameters().len());
            parameters.fold(Vector3::zeros(), |sum, (k, (parameter, sigma))| {
                let is_taken_out = *parameter != 0.0;
                if is_taken_out { sum + (effect.term(k, snapshot) * *sigma).map(|x| x * x) } else { sum }
            })
        })
    }

    /// Sums over the effects of the accelerometer, and over those of the magnetometer.
    fn sums_of_vectors(
        &self,
        library: &[&dyn Effect],
        of: impl Fn(&dyn Effect, &FoundEffect) -> Vector3<f32>,
    ) -> [Vector3<f32>; 2] {
        let [mut of_force, mut of_field] = [Vector3::zeros(); 2];
        for found in self.iter() {
            let Some(effect) = library.get(usize::from(found.index)) else { continue };
            let sum = match effect.sensor() {
                Sensor::Gyro => continue,
                Sensor::Accelerometer => &mut of_force,
                Sensor::Magnetometer => &mut of_field,
            };
            *sum += of(*effect, found);
        }
        [of_force, of_field]
    }

    /// Delay of the gyro's reading, and so of everything valid at the rate's time, seconds.
    #[must_use]
    pub fn gyro_delay_s(&self, library: &[&dyn Effect]) -> f32 {
        self.iter().fold(0.0, |sum, found| {
            sum + library.get(usize::from(found.index)).map_or(0.0, |effect| effect.gyro_delay_s(&found.parameters))
        })
    }
}

/// Serialises as a sequence of the effects in the set.
#[cfg(feature = "serde")]
impl serde::Serialize for ActiveEffects {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = self.found.get(..usize::from(self.count)).unwrap_or_default();
        serde::Serialize::serialize(found, serializer)
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for ActiveEffects {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let found = heapless::Vec::<FoundEffect, MAX_ACTIVE>::deserialize(deserializer)?;
        let mut effects = Self::none();
        for effect in found {
            effects.add(effect);
        }
        Ok(effects)
    }
}

/// Sum of the terms that one effect with these parameters adds to its sensor's reading.
fn contribution(effect: &dyn Effect, parameters: &[f32; MAX_PARAMETERS], snapshot: &Snapshot) -> Vector3<f32> {
    let terms = parameters.iter().enumerate().take(effect.parameters().len());
    terms.fold(Vector3::zeros(), |sum, (k, x)| if *x == 0.0 { sum } else { sum + effect.term(k, snapshot) * *x })
}
