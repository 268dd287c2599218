/// Increments that share one entry: a fifth of a second or so.
const SHARED: u32 = 10;

/// Entries: as many as the increments that are kept need, and one in progress.
const ENTRIES: usize = 263;

/// What changes slowly, in means over a fifth of a second: how hard it shakes, and how warm it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surroundings {
    /// Mean square of the specific force, m^2/s^4.
    pub square_force_m2_s4: f32,
    /// Temperature, degrees Celsius; `None` where it was not read.
    pub temperature_c: Option<f32>,
}

/// No temperature: the zero of a static. A temperature of exactly 0 degC is stored as a hundredth more.
const NONE: i16 = 0;

/// The latest surroundings, in step with the increments.
pub(crate) struct SurroundingsRing {
    square_forces: [f32; ENTRIES],
    /// In hundredths of a degree.
    temperatures_c: [i16; ENTRIES],
    square_sum: f32,
    squares: u16,
    temperature_sum: f32,
    temperatures: u16,
}

impl SurroundingsRing {
    pub const fn zero() -> Self {
        Self {
            square_forces: [0.0; ENTRIES],
            temperatures_c: [NONE; ENTRIES],
            square_sum: 0.0,
            squares: 0,
            temperature_sum: 0.0,
            temperatures: 0,
        }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Adds one sample's specific force, m/s^2 squared, and temperature, degrees Celsius.
    pub fn add(&mut self, square_force: Option<f32>, temperature_c: Option<f32>) {
        if let Some(square) = square_force {
            self.square_sum += square;
            self.squares = self.squares.saturating_add(1);
        }
        if let Some(temperature) = temperature_c {
            self.temperature_sum += temperature;
            self.temperatures = self.temperatures.saturating_add(1);
        }
    }

    /// Increment `index` has been completed.
    pub fn complete(&mut self, index: u32) {
        if index % SHARED != SHARED - 1 {
            return;
        }
        let mean = |sum: f32, count: u16| (count > 0).then(|| sum / f32::from(count));
        let place = (index / SHARED) as usize % ENTRIES;
        if let Some(slot) = self.square_forces.get_mut(place) {
            *slot = mean(self.square_sum, self.squares).unwrap_or(0.0);
        }
        if let Some(slot) = self.temperatures_c.get_mut(place) {
            let hundredths = mean(self.temperature_sum, self.temperatures).map(|c| libm::roundf(c * 100.0));
            let stored = hundredths.filter(|c| libm::fabsf(*c) <= f32::from(i16::MAX) && *c != 0.0);
            *slot = stored.map_or(if hundredths.is_some() { 1 } else { NONE }, |c| c as i16);
        }
        (self.square_sum, self.squares, self.temperature_sum, self.temperatures) = (0.0, 0, 0.0, 0);
    }

    /// Those of the fifth of a second before increment `index`, which must be one that is kept: its own may still be in progress.
    pub fn get(&self, index: u32) -> Surroundings {
        let place = (index / SHARED).wrapping_sub(1) as usize % ENTRIES;
        let temperature = self.temperatures_c.get(place).copied().filter(|c| *c != NONE);
        Surroundings {
            square_force_m2_s4: self.square_forces.get(place).copied().unwrap_or(0.0),
            temperature_c: temperature.map(|c| f32::from(c) * 0.01),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_stand_for_the_increments_after_those_that_they_were_made_of() {
        let mut ring = SurroundingsRing::zero();
        ring.start();
        for index in 0..3_000 {
            ring.add(Some((index / SHARED) as f32), (index % 2 == 0).then_some(20.0 + (index / SHARED) as f32));
            ring.add(None, None);
            ring.complete(index);
        }
        for index in 400..3_000 {
            let entry = (index / SHARED - 1) as f32;
            let expected = Surroundings { square_force_m2_s4: entry, temperature_c: Some(20.0 + entry) };
            let found = ring.get(index);
            assert_eq!(found.square_force_m2_s4, expected.square_force_m2_s4, "{index}");
            let [found, expected] = [found, expected].map(|s| s.temperature_c.unwrap());
            assert!((found - expected).abs() < 0.006, "{index}: {found} {expected}");
        }
    }

    #[test]
    fn what_was_not_read_is_none() {
        let mut ring = SurroundingsRing::zero();
        (0..20).for_each(|index| ring.complete(index));
        assert_eq!(ring.get(13), Surroundings { square_force_m2_s4: 0.0, temperature_c: None });
    }
}
