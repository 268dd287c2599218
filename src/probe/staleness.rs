//! Staleness: a sensor that repeats its readings, or an axis that is dead. `reading_checks.rs` sets the times.

/// Readings after which an axis is dead: repeats of a value while another axis changes and the probe turns (a live axis
/// would change too), or exact zeros, which a dead axis reads. Repeats at rest do not count, because a good sensor's
/// noise may be below its resolution.
const DEAD_READINGS: u8 = 50;

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
mod tests;
