use super::effect::{Effect, MAX_PARAMETERS, Moment, Sensor};
use nalgebra::Vector3;

/// Most effects that are taken out at a time.
pub const MAX_ACTIVE: usize = 8;

/// An effect of the library with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoundEffect {
    /// Its place in the library.
    pub index: u8,
    /// Its parameters, SI (field: microtesla); zero beyond its dimension.
    pub parameters: [f32; MAX_PARAMETERS],
    /// Their 1-sigma.
    pub sigma: [f32; MAX_PARAMETERS],
}

/// The effects that are taken out of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub struct ActiveEffects {
    found: [FoundEffect; MAX_ACTIVE],
    count: u8,
}

impl ActiveEffects {
    /// No effect.
    #[must_use]
    pub const fn none() -> Self {
        const NONE: FoundEffect =
            FoundEffect { index: 0, parameters: [0.0; MAX_PARAMETERS], sigma: [0.0; MAX_PARAMETERS] };
        Self { found: [NONE; MAX_ACTIVE], count: 0 }
    }

    /// Adds one; `false` when there is no room.
    pub fn add(&mut self, effect: FoundEffect) -> bool {
        let slot = self.found.get_mut(usize::from(self.count));
        let Some(slot) = slot else { return false };
        *slot = effect;
        self.count += 1;
        true
    }

    /// The same without what only turns a sensor's axes: what attitude is corrected by.
    #[must_use]
    pub fn of_attitude(&self, library: &[&dyn Effect]) -> Self {
        let mut rest = *self;
        for found in &mut rest.found {
            let Some(effect) = library.get(usize::from(found.index)) else { continue };
            for (value, parameter) in found.parameters.iter_mut().zip(effect.parameters()) {
                if parameter.only_in_estimator {
                    *value = 0.0;
                }
            }
        }
        rest
    }

    /// Those that there are.
    pub fn iter(&self) -> impl Iterator<Item = &FoundEffect> {
        self.found.iter().take(usize::from(self.count))
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Takes the effects out of one instant's readings, the gyro's first, since the other terms depend on the rate.
    pub fn correct(&self, library: &[&dyn Effect], moment: &mut Moment) {
        if self.is_empty() {
            return;
        }
        self.correct_rate(library, moment);
        self.correct_vectors(library, moment);
        let delay_s = self.gyro_delay_s(library);
        if delay_s != 0.0 {
            let turn = moment.rate_rad_s * delay_s;
            moment.force_m_s2 += turn.cross(&moment.force_m_s2);
            moment.field_ut += turn.cross(&moment.field_ut);
        }
    }

    /// Takes those of the gyro out of the rate.
    pub(crate) fn correct_rate(&self, library: &[&dyn Effect], moment: &mut Moment) {
        moment.rate_rad_s -= self.sum(library, Sensor::Gyro, moment);
    }

    /// Takes those of accelerometer and magnetometer out. What a sensor reads more whatever its vector is goes first: it does not lag. The other
    /// terms are those halfway between what is left and the truth, so that a lag is taken out to second order: exactly to 1e-4 at 15 ms and
    /// 300 deg/s.
    pub(crate) fn correct_vectors(&self, library: &[&dyn Effect], moment: &mut Moment) {
        if self.is_empty() {
            return;
        }
        let read = [moment.force_m_s2, moment.field_ut];
        let added_to = |[force_m_s2, field_ut]: [Vector3<f32>; 2]| {
            let moment = Moment { force_m_s2, field_ut, ..*moment };
            [Sensor::Accelerometer, Sensor::Magnetometer].map(|sensor| self.sum(library, sensor, &moment))
        };
        let less = |[a, b]: [Vector3<f32>; 2], [x, y]: [Vector3<f32>; 2], share: f32| [a - x * share, b - y * share];
        let constant = added_to([Vector3::zeros(); 2]);
        let left = less(read, constant, 1.0);
        let halfway = less(left, less(added_to(left), constant, 1.0), 0.5);
        [moment.force_m_s2, moment.field_ut] = less(read, added_to(halfway), 1.0);
    }

    /// What the effects of one sensor add to its reading; a delay of the whole gyro adds nothing.
    fn sum(&self, library: &[&dyn Effect], sensor: Sensor, moment: &Moment) -> Vector3<f32> {
        self.iter().fold(Vector3::zeros(), |sum, found| {
            let effect = library.get(usize::from(found.index)).filter(|effect| effect.sensor() == sensor);
            match effect.filter(|effect| effect.gyro_delay_s(&found.parameters) == 0.0) {
                Some(effect) => sum + contribution(*effect, &found.parameters, moment),
                None => sum,
            }
        })
    }

    /// How late the gyro's reading is, and with it all that is valid when the rate is, seconds.
    #[must_use]
    pub fn gyro_delay_s(&self, library: &[&dyn Effect]) -> f32 {
        self.iter().fold(0.0, |sum, found| {
            sum + library.get(usize::from(found.index)).map_or(0.0, |effect| effect.gyro_delay_s(&found.parameters))
        })
    }
}

/// As a sequence of those that there are.
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

/// What an effect with these parameters adds to its sensor's reading.
fn contribution(effect: &dyn Effect, parameters: &[f32; MAX_PARAMETERS], moment: &Moment) -> Vector3<f32> {
    let terms = parameters.iter().enumerate().take(effect.parameters().len());
    terms.fold(Vector3::zeros(), |sum, (k, x)| if *x == 0.0 { sum } else { sum + effect.term(k, moment) * *x })
}
