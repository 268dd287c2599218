/// An axis that reads exactly zero so many times while the others do not is dead: a live one has noise.
const DEAD_READINGS: u16 = 50;

/// Counts how long a sensor has given the same reading, missing ones left out.
#[derive(Clone, Copy)]
pub(super) struct Staleness {
    last: [f32; 3],
    /// The reading before the first one that was as the last.
    before: [f32; 3],
    pub same: u32,
    /// Zeros in a row, by axis.
    zeros: [u16; 3],
}

impl Staleness {
    pub const fn zero() -> Self {
        Self { last: [0.0; 3], before: [0.0; 3], same: 0, zeros: [0; 3] }
    }

    pub fn observe(&mut self, reading: [f32; 3]) {
        for (zeros, x) in self.zeros.iter_mut().zip(reading) {
            *zeros = if x == 0.0 { zeros.saturating_add(1) } else { 0 };
        }
        if reading == self.last {
            self.same = self.same.saturating_add(1);
        } else {
            (self.before, self.last, self.same) = (self.last, reading, 0);
        }
    }

    /// Whether an axis is dead.
    pub fn has_dead_axis(&self) -> bool {
        self.zeros.iter().any(|zeros| *zeros >= DEAD_READINGS)
    }

    /// Whether the reading and the one before it were below `limit` on all axes.
    pub fn is_still(&self, limit: f32) -> bool {
        self.last.iter().chain(&self.before).all(|x| libm::fabsf(*x) < limit)
    }
}
