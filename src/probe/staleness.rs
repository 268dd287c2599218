//! Staleness: a sensor that repeats its readings, or an axis that is dead. `reading_checks.rs` sets the times.

/// Readings after which an axis is dead: repeats of a value while another axis changes and the probe turns (a live axis
/// would change too), or exact zeros, which a dead axis reads. Repeats at rest do not count, because a good sensor's
/// noise may be below its resolution.
const DEAD_READINGS: u16 = 50;

/// Detector of a sensor that repeats its reading; missing readings do not count.
#[derive(Clone, Copy)]
pub(super) struct Staleness {
    /// Last reading, as bits: they compare faster.
    last: [u32; 3],
    /// Reading before the first repeat of the last one.
    before: [u32; 3],
    pub same: u32,
    /// Consecutive zeros, and repeats while the probe turned, of each axis.
    repeated: [u16; 3],
}

impl Staleness {
    pub const fn zero() -> Self {
        Self { last: [0; 3], before: [0; 3], same: 0, repeated: [0; 3] }
    }

    /// Takes a reading; `turning` is true if the probe turns.
    pub fn update(&mut self, reading: [f32; 3], turning: bool) {
        let reading = reading.map(f32::to_bits);
        let [[x, y, z], [last_x, last_y, last_z]] = [reading, self.last];
        let has_zero = x << 1 == 0 || y << 1 == 0 || z << 1 == 0;
        if !has_zero && x != last_x && y != last_y && z != last_z {
            // The usual case: every axis has changed and none is zero.
            *self = Self { last: reading, before: self.last, same: 0, repeated: [0; 3] };
            return;
        }
        self.judge(reading, turning);
    }

    /// Takes a reading in which an axis is zero or repeats itself.
    #[inline(never)]
    fn judge(&mut self, reading: [u32; 3], turning: bool) {
        let is_new = reading != self.last;
        for ((repeated, x), last) in self.repeated.iter_mut().zip(reading).zip(self.last) {
            // A zero of either sign.
            if x << 1 == 0 || x == last && is_new && turning {
                *repeated = repeated.saturating_add(1);
            } else if x != last {
                *repeated = 0;
            }
        }
        self.same = if is_new { 0 } else { self.same.saturating_add(1) };
        if is_new {
            (self.before, self.last) = (self.last, reading);
        }
    }

    /// Returns true if an axis is dead.
    pub fn has_dead_axis(&self) -> bool {
        self.repeated.iter().any(|repeated| *repeated >= DEAD_READINGS)
    }

    /// Returns true if the last two different readings were below `limit` on all axes.
    pub fn is_still(&self, limit: f32) -> bool {
        self.last.iter().chain(&self.before).all(|x| libm::fabsf(f32::from_bits(*x)) < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns true if an axis counts as dead after `readings` at `x`, while the other axes change every `hold`
    /// readings.
    fn is_dead(x: f32, readings: u16, hold: u16, turning: bool) -> bool {
        let mut staleness = Staleness::zero();
        for k in 0..readings {
            let live = f32::from(k / hold) * 0.1 + 1.0;
            staleness.update([live, x, -live], turning);
        }
        staleness.has_dead_axis()
    }

    #[test]
    fn an_axis_that_repeats_itself_is_dead_if_the_probe_turns_or_it_is_zero() {
        assert!(is_dead(0.3, DEAD_READINGS + 1, 1, true) && !is_dead(0.3, DEAD_READINGS, 1, true));
        assert!(!is_dead(0.3, 1000, 1, false), "the noise of a good sensor at rest is below its resolution");
        assert!(is_dead(0.0, DEAD_READINGS, 1, false) && is_dead(-0.0, DEAD_READINGS, 1, false));
        // A sensor that is read more often than it converts is judged by its new readings only.
        assert!(!is_dead(0.3, DEAD_READINGS, 5, true) && is_dead(0.3, 5 * DEAD_READINGS + 5, 5, true));
    }

    #[test]
    fn one_that_changes_is_alive_again() {
        let mut staleness = Staleness::zero();
        let mut is_dead = |reading: [f32; 3], turning| {
            staleness.update(reading, turning);
            staleness.has_dead_axis()
        };
        assert!((0..100_u8).any(|k| is_dead([0.3, f32::from(k), 1.0 + f32::from(k)], true)));
        assert!(is_dead([0.3, 0.1, 0.2], false), "a rest says nothing");
        assert!(!is_dead([0.31, 0.2, 0.3], true));
    }
}
