/// Increments that share one entry: a fifth of a second or so.
pub(crate) const SHARED: u32 = 10;

/// Entries: as many as the increments that are kept need, and one in progress.
const ENTRIES: usize = 235;

/// What changes slowly, in means over a fifth of a second: how hard it shakes, and how warm it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surroundings {
    /// Mean square of the specific force, m^2/s^4.
    pub square_force_m2_s4: f32,
    /// Its largest square in any sample, m^2/s^4: the mean dilutes a shock of a few milliseconds.
    pub largest_square_m2_s4: f32,
    /// Temperature, degrees Celsius; `None` where it was not read.
    pub temperature_c: Option<f32>,
}

/// No temperature: the zero of a static. A temperature of exactly 0 degC is stored as a hundredth more.
const NONE: i16 = 0;

/// The latest surroundings, in step with the increments.
pub(crate) struct SurroundingsRing {
    /// Mean and largest square, each the upper half of an f32: to 0.4 %.
    square_forces: [[u16; 2]; ENTRIES],
    /// In hundredths of a degree.
    temperatures_c: [i16; ENTRIES],
    square_sum: f32,
    largest_square: f32,
    squares: u16,
    temperature_sum: f32,
    temperatures: u16,
}

/// The upper half of an f32 that is not negative, rounded.
pub(crate) const fn halved(x: f32) -> u16 {
    (x.to_bits().saturating_add(0x8000) >> 16) as u16
}

/// An f32 of its upper half.
pub(crate) const fn whole(half: u16) -> f32 {
    f32::from_bits((half as u32) << 16)
}

impl SurroundingsRing {
    pub const fn zero() -> Self {
        Self {
            square_forces: [[0; 2]; ENTRIES],
            temperatures_c: [NONE; ENTRIES],
            square_sum: 0.0,
            largest_square: 0.0,
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
            self.largest_square = if square > self.largest_square { square } else { self.largest_square };
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
            *slot = [mean(self.square_sum, self.squares).unwrap_or(0.0), self.largest_square].map(halved);
        }
        if let Some(slot) = self.temperatures_c.get_mut(place) {
            let hundredths = mean(self.temperature_sum, self.temperatures).map(|c| libm::roundf(c * 100.0));
            let stored = hundredths.filter(|c| libm::fabsf(*c) <= f32::from(i16::MAX) && *c != 0.0);
            *slot = stored.map_or(if hundredths.is_some() { 1 } else { NONE }, |c| c as i16);
        }
        (self.square_sum, self.squares, self.temperature_sum, self.temperatures) = (0.0, 0, 0.0, 0);
        self.largest_square = 0.0;
    }

    /// Those of the fifth of a second before increment `index`, which must be one that is kept: its own may still be in progress.
    pub fn get(&self, index: u32) -> Surroundings {
        let place = (index / SHARED).wrapping_sub(1) as usize % ENTRIES;
        let temperature = self.temperatures_c.get(place).copied().filter(|c| *c != NONE);
        let [mean, largest] = self.square_forces.get(place).map_or([0.0; 2], |squares| squares.map(whole));
        Surroundings {
            square_force_m2_s4: mean,
            largest_square_m2_s4: largest,
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
        for index in 700..3_000 {
            let entry = (index / SHARED - 1) as f32;
            let found = ring.get(index);
            for square in [found.square_force_m2_s4, found.largest_square_m2_s4] {
                assert!((square - entry).abs() <= 0.004 * entry, "{index}: {square} {entry}");
            }
            let (found, expected) = (found.temperature_c.unwrap(), 20.0 + entry);
            assert!((found - expected).abs() < 0.006, "{index}: {found} {expected}");
        }
    }

    #[test]
    fn what_was_not_read_is_none() {
        let mut ring = SurroundingsRing::zero();
        (0..20).for_each(|index| ring.complete(index));
        let nothing = Surroundings { square_force_m2_s4: 0.0, largest_square_m2_s4: 0.0, temperature_c: None };
        assert_eq!(ring.get(13), nothing);
    }

    #[test]
    fn one_sample_of_a_shock_is_kept() {
        let mut ring = SurroundingsRing::zero();
        for index in 0..30 {
            (0..2).for_each(|k| ring.add(Some(if (index, k) == (13, 1) { 40_000.0 } else { 100.0 }), None));
            ring.complete(index);
        }
        let largest = [5, 15, 25, 30].map(|index| ring.get(index).largest_square_m2_s4);
        assert!((largest[2] / 40_000.0 - 1.0).abs() < 0.004, "{largest:?}");
        assert!((largest[1] / 100.0 - 1.0).abs() < 0.004 && (largest[3] / 100.0 - 1.0).abs() < 0.004, "{largest:?}");
    }
}
