/// Increments that share one entry: a fifth of a second or so.
const SHARED: u32 = 10;

/// Entries: as many as the increments that are kept need, and one in progress.
const ENTRIES: usize = 262;

/// What changes slowly, in means over a fifth of a second: how hard it shakes, and how warm it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surroundings {
    /// Mean square of the specific force, m^2/s^4.
    pub square_force_m2_s4: f32,
    /// Temperature, degrees Celsius; `None` where it was not read.
    pub temperature_c: Option<f32>,
}

impl Surroundings {
    const NOTHING: Self = Self { square_force_m2_s4: 0.0, temperature_c: None };
}

/// The latest surroundings, in step with the increments.
pub(crate) struct SurroundingsRing {
    entries: [Surroundings; ENTRIES],
    square_sum: f32,
    squares: u16,
    temperature_sum: f32,
    temperatures: u16,
}

impl SurroundingsRing {
    pub const fn zero() -> Self {
        Self {
            entries: [Surroundings { square_force_m2_s4: 0.0, temperature_c: None }; ENTRIES],
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
        let entry = Surroundings {
            square_force_m2_s4: mean(self.square_sum, self.squares).unwrap_or(0.0),
            temperature_c: mean(self.temperature_sum, self.temperatures),
        };
        if let Some(slot) = self.entries.get_mut((index / SHARED) as usize % ENTRIES) {
            *slot = entry;
        }
        (self.square_sum, self.squares, self.temperature_sum, self.temperatures) = (0.0, 0, 0.0, 0);
    }

    /// Those of increment `index`, which must be one that is kept.
    pub fn get(&self, index: u32) -> Surroundings {
        self.entries.get((index / SHARED) as usize % ENTRIES).copied().unwrap_or(Surroundings::NOTHING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_stand_for_the_increments_that_they_were_made_of() {
        let mut ring = SurroundingsRing::zero();
        ring.start();
        for index in 0..3_000 {
            ring.add(Some((index / SHARED) as f32), (index % 2 == 0).then_some(20.0 + (index / SHARED) as f32));
            ring.add(None, None);
            ring.complete(index);
        }
        for index in 400..3_000 {
            let entry = (index / SHARED) as f32;
            let expected = Surroundings { square_force_m2_s4: entry, temperature_c: Some(20.0 + entry) };
            assert_eq!(ring.get(index), expected, "{index}");
        }
    }

    #[test]
    fn what_was_not_read_is_none() {
        let mut ring = SurroundingsRing::zero();
        (0..10).for_each(|index| ring.complete(index));
        assert_eq!(ring.get(3), Surroundings::NOTHING);
    }
}
