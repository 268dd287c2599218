/// Counts how long a sensor has given the same reading, missing ones left out.
#[derive(Clone, Copy)]
pub(super) struct Staleness {
    last: [f32; 3],
    /// The reading before the first one that was as the last.
    before: [f32; 3],
    pub same: u32,
}

impl Staleness {
    pub const fn zero() -> Self {
        Self { last: [0.0; 3], before: [0.0; 3], same: 0 }
    }

    pub fn observe(&mut self, reading: [f32; 3]) {
        if reading == self.last {
            self.same = self.same.saturating_add(1);
        } else {
            (self.before, self.last, self.same) = (self.last, reading, 0);
        }
    }

    /// Whether the reading and the one before it were below `limit` on all axes.
    pub fn is_still(&self, limit: f32) -> bool {
        self.last.iter().chain(&self.before).all(|x| libm::fabsf(*x) < limit)
    }
}
