//! Staleness: a sensor that repeats its readings, or an axis that is dead. `reading_checks.rs` sets the times.

/// Readings after which an axis is dead: repeats of a value while another axis changes and the probe turns (a live axis
/// would change too), or exact zeros, which a dead axis reads. Repeats at rest do not count, because a good sensor's
/// noise may be below its resolution.
const DEAD_READINGS: u8 = 50;

/// New readings in a row, none of which repeats itself, after which a sensor counts as one whose noise shows in every
/// reading.
const LIVELY: u8 = 128;
/// Readings that a repeat takes back once it has ended: a freeze or two do not tell of a sensor whose noise is below its
/// resolution, or that is read more often than it converts.
const REPEAT: u8 = 48;

/// Detector of a sensor that repeats its reading; missing readings do not count.
#[derive(Clone, Copy)]
pub(super) struct Staleness {
    /// Last reading, as bits: they compare faster.
    last: [u32; 3],
    /// Reading before the first repeat of the last one.
    before: [u32; 3],
    pub same: u32,
    /// Consecutive zeros, and repeats while the probe turned, of each axis.
    repeated: [u8; 3],
    /// The same, of repeats while the probe turned alone.
    turned: [u8; 3],
    /// New readings without a repeat, less those that ended repeats take back.
    fresh: u8,
}

impl Staleness {
    pub const fn zero() -> Self {
        Self { last: [0; 3], before: [0; 3], same: 0, repeated: [0; 3], turned: [0; 3], fresh: 0 }
    }

    /// Takes a reading; `turning` is true if the probe turns.
    pub fn update(&mut self, reading: [f32; 3], turning: bool) {
        let reading = reading.map(f32::to_bits);
        let [[x, y, z], [last_x, last_y, last_z]] = [reading, self.last];
        let has_zero = x << 1 == 0 || y << 1 == 0 || z << 1 == 0;
        if !has_zero && x != last_x && y != last_y && z != last_z {
            // The usual case: every axis has changed and none is zero.
            *self = Self { last: reading, before: self.last, fresh: self.next_fresh(), ..Self::zero() };
            return;
        }
        self.judge(reading, turning);
    }

    /// Takes a reading in which an axis is zero or repeats itself.
    #[inline(never)]
    fn judge(&mut self, reading: [u32; 3], turning: bool) {
        let is_new = reading != self.last;
        let counted = self.repeated.iter_mut().zip(&mut self.turned);
        for (((repeated, turned), x), last) in counted.zip(reading).zip(self.last) {
            let has_turned = x == last && is_new && turning;
            // A zero of either sign.
            if x << 1 == 0 || has_turned {
                *repeated = repeated.saturating_add(1);
            } else if x != last {
                *repeated = 0;
            }
            if has_turned {
                *turned = turned.saturating_add(1);
            } else if x != last {
                *turned = 0;
            }
        }
        if is_new {
            self.fresh = self.next_fresh();
        }
        self.same = if is_new { 0 } else { self.same.saturating_add(1) };
        if is_new {
            (self.before, self.last) = (self.last, reading);
        }
    }

    /// Count of fresh readings after a new one.
    const fn next_fresh(&self) -> u8 {
        if self.same > 0 { self.fresh.saturating_sub(REPEAT) } else { self.fresh.saturating_add(1) }
    }

    /// Returns true if every reading has lately been a new one.
    pub const fn is_lively(&self) -> bool {
        self.fresh >= LIVELY
    }

    /// Returns true if an axis is dead.
    pub fn has_dead_axis(&self) -> bool {
        self.repeated.iter().any(|repeated| *repeated >= DEAD_READINGS)
    }

    /// Returns true if an axis has repeated itself while the probe turned: zeros at rest do not count.
    pub fn has_dead_turning_axis(&self) -> bool {
        self.turned.iter().any(|turned| *turned >= DEAD_READINGS)
    }

    /// Returns true if the last two different readings were below `limit` on all axes.
    pub fn is_still(&self, limit: f32) -> bool {
        self.last.iter().chain(&self.before).all(|x| libm::fabsf(f32::from_bits(*x)) < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEAD: u16 = DEAD_READINGS as u16;

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
        assert!(is_dead(0.3, DEAD + 1, 1, true) && !is_dead(0.3, DEAD, 1, true));
        assert!(!is_dead(0.3, 1000, 1, false), "the noise of a good sensor at rest is below its resolution");
        assert!(is_dead(0.0, DEAD, 1, false) && is_dead(-0.0, DEAD, 1, false));
        // A sensor that is read more often than it converts is judged by its new readings only.
        assert!(!is_dead(0.3, DEAD, 5, true) && is_dead(0.3, 5 * DEAD + 5, 5, true));
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

    #[test]
    fn a_sensor_is_lively_until_its_readings_repeat_themselves_again_and_again() {
        let mut staleness = Staleness::zero();
        let mut next = 0.0;
        let mut fresh = |staleness: &mut Staleness, readings: u16, hold: u16| {
            for k in 0..readings {
                next += if k % hold == 0 { 0.1 } else { 0.0 };
                staleness.update([next, next + 1.0, -next], false);
            }
            staleness.is_lively()
        };
        assert!(!fresh(&mut staleness, 127, 1) && fresh(&mut staleness, 73, 1));
        // One freeze, however long, is not its nature.
        assert!(fresh(&mut staleness, 300, 300) && fresh(&mut staleness, 1, 1));
        // Read three times as often as it converts, it repeats itself by nature.
        assert!(!fresh(&mut staleness, 12, 3));
    }

    #[test]
    fn an_axis_of_zeros_is_dead_where_the_probe_turns_and_not_at_rest() {
        let is_dead = |turning| {
            let mut staleness = Staleness::zero();
            for k in 0..=DEAD {
                staleness.update([f32::from(k), 0.0, -f32::from(k)], turning);
            }
            staleness.has_dead_turning_axis()
        };
        assert!(is_dead(true) && !is_dead(false));
    }
}
