use super::effect::{Effect, MAX_PARAMETERS, Moment, Sensor};
use nalgebra::Vector3;

/// Most effects that are taken out at a time.
pub const MAX_ACTIVE: usize = 6;

/// An effect of the library with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
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
        let delay_s = self.gyro_delay_s(library);
        for sensor in [Sensor::Gyro, Sensor::Accelerometer, Sensor::Magnetometer] {
            let mut sum = Vector3::zeros();
            for found in self.iter() {
                let effect = library.get(usize::from(found.index)).filter(|effect| effect.sensor() == sensor);
                let Some(effect) = effect.filter(|effect| effect.gyro_delay_s(&found.parameters) == 0.0) else { continue };
                sum += contribution(*effect, &found.parameters, moment);
            }
            match sensor {
                Sensor::Gyro => moment.rate_rad_s -= sum,
                Sensor::Accelerometer => moment.force_m_s2 -= sum,
                Sensor::Magnetometer => moment.field_ut -= sum,
            }
        }
        if delay_s != 0.0 {
            let turn = moment.rate_rad_s * delay_s;
            moment.force_m_s2 += turn.cross(&moment.force_m_s2);
            moment.field_ut += turn.cross(&moment.field_ut);
        }
    }

    /// How late the gyro's reading is, and with it all that is valid when the rate is, seconds.
    #[must_use]
    pub fn gyro_delay_s(&self, library: &[&dyn Effect]) -> f32 {
        self.iter().fold(0.0, |sum, found| {
            sum + library.get(usize::from(found.index)).map_or(0.0, |effect| effect.gyro_delay_s(&found.parameters))
        })
    }
}

/// What an effect with these parameters adds to its sensor's reading.
pub(crate) fn contribution(effect: &dyn Effect, parameters: &[f32; MAX_PARAMETERS], moment: &Moment) -> Vector3<f32> {
    let terms = parameters.iter().enumerate().take(effect.parameters().len());
    terms.fold(Vector3::zeros(), |sum, (k, x)| if *x == 0.0 { sum } else { sum + effect.term(k, moment) * *x })
}
