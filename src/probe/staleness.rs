//! Staleness: a sensor that repeats its readings, or an axis that is dead. `reading_checks.rs` sets the times, which
//! are seconds: a sensor that is read less often than the gyro is stale as soon.

/// Readings after which an axis is dead: repeats of a value while another axis changes and the probe turns (a live axis
/// would change too), or exact zeros, which a dead axis reads. Repeats at rest do not count, because a good sensor's
/// noise may be below its resolution.
const DEAD_READINGS: u8 = 50;

/// Longest time that a reading counts to have been the same since the one before it, seconds: a magnetometer that is
/// read four times a second. In a longer time without readings a sensor may have read something else.
pub(super) const LONGEST_INTERVAL_S: f32 = 0.25;
/// Repeats with which a sensor may count as one that repeats itself: fewer are common where noise is below the
/// resolution. At 100 Hz they are the shortest time after which a sensor is stale.
const LEAST_REPEATS: u8 = 5;

/// New readings in a row, none of which repeats itself, after which a sensor counts as one whose noise shows in every
/// reading.
const LIVELY: u8 = 128;
/// Readings that a repeat takes back once it has ended: a freeze or two do not tell of a sensor whose noise is below
/// its resolution, or that is read more often than it converts.
const REPEAT: u8 = 48;

/// Detector of a sensor that repeats its reading; missing readings do not count.
#[derive(Clone, Copy)]
pub(super) struct Staleness {
    /// Last reading, as bits: they compare faster.
    last: [u32; 3],
    /// Time for which the readings have been the same, and time since the last reading, seconds.
    same_s: f32,
    unread_s: f32,
    /// Repeats of the last reading.
    repeats: u8,
    /// True if the probe turned at the last reading, and at the different one before it.
    has_turned: [bool; 2],
    /// Consecutive zeros, and repeats while the probe turned, of each axis.
    repeated: [u8; 3],
    /// Consecutive repeats of each axis while the probe turned, without zeros.
    turned: [u8; 3],
    /// New readings without a repeat, less those that ended repeats take back.
    fresh: u8,
}

impl Staleness {
    pub const fn zero() -> Self {
        Self {
            last: [0; 3],
            same_s: 0.0,
            unread_s: 0.0,
            repeats: 0,
            has_turned: [false; 2],
            repeated: [0; 3],
            turned: [0; 3],
            fresh: 0,
        }
    }

    /// Adds the time from the sample before to this one, with or without a reading.
    pub fn pass(&mut self, step_s: f32) {
        self.unread_s += step_s;
    }

    /// Axes on which a reading repeats the last one, a bit each.
    pub fn repeats(&self, reading: [f32; 3]) -> u8 {
        self.last.iter().zip(reading).fold(0, |axes, (last, x)| axes << 1 | u8::from(x.to_bits() == *last))
    }

    /// Takes a reading; `turning` is true if the probe turns.
    pub fn update(&mut self, reading: [f32; 3], turning: bool) {
        let reading = reading.map(f32::to_bits);
        let [[x, y, z], [last_x, last_y, last_z]] = [reading, self.last];
        let has_zero = x << 1 == 0 || y << 1 == 0 || z << 1 == 0;
        if !has_zero && x != last_x && y != last_y && z != last_z {
            // The usual case: every axis has changed and none is zero.
            let has_turned = self.turning_after(turning);
            *self = Self { last: reading, has_turned, fresh: self.next_fresh(), ..Self::zero() };
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
            self.has_turned = self.turning_after(turning);
            self.last = reading;
            (self.same_s, self.repeats) = (0.0, 0);
        } else {
            self.same_s += if self.unread_s < LONGEST_INTERVAL_S { self.unread_s } else { LONGEST_INTERVAL_S };
            self.repeats = self.repeats.saturating_add(1);
        }
        self.unread_s = 0.0;
    }

    /// [`Self::has_turned`] after a new reading.
    const fn turning_after(&self, turning: bool) -> [bool; 2] {
        let [last, _] = self.has_turned;
        [turning, last]
    }

    /// Count of fresh readings after a new one.
    const fn next_fresh(&self) -> u8 {
        if self.repeats > 0 { self.fresh.saturating_sub(REPEAT) } else { self.fresh.saturating_add(1) }
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

    /// Returns true if the probe did not turn at the last two different readings.
    pub const fn is_still(&self) -> bool {
        matches!(self.has_turned, [false, false])
    }

    /// Returns true if the readings had been the same for longer than this time, seconds, when the sensor was last
    /// read.
    pub fn has_repeated_for(&self, seconds: f32) -> bool {
        self.same_s > seconds && self.repeats >= LEAST_REPEATS
    }
}

#[cfg(test)]
mod tests;
