//! Change of a quiet gyro's mean rate: a turn too slow to be no rest, or another bias.

use crate::statistics::chi_square::IN_A_MILLION;
use nalgebra::Vector3;

/// Memory of the latest mean, blocks.
const LATEST: f32 = 6.0;
/// Blocks of which a plain mean varies as much as an exponential one with this memory.
const LIKE: f32 = 2.0 * LATEST - 1.0;
/// Blocks before a change is judged, and from which on their scatter counts as known: to a third (18 squares).
const LEAST: u16 = 6;
/// Blocks that the mean remembers: two minutes, in which a gyro's bias wanders by less than its noise.
const MOST: u16 = 240;

/// Longest jerk after which a gyro's mean rate is still the one before it, seconds: a string that begins to untwist; a
/// motion that lasts may warm it.
const JERK_S: f32 = 5.0;
/// Variance of a mean before the first block, (rad/s)^2: more than any gyro's bias.
const UNKNOWN: f32 = 1.0;

/// Mean rate of a quiet gyro, by blocks of half a second, and its latest change.
pub(super) struct RestRate {
    /// Mean before the change, rad/s.
    pub mean: Vector3<f32>,
    /// Variance of that mean, on each axis, (rad/s)^2; [`UNKNOWN`] before the first blocks.
    pub variance: f32,
    /// Latest mean less that one, rad/s.
    latest: Vector3<f32>,
    /// Variance of a block's mean, of each axis, (rad/s)^2.
    scatter: f32,
    blocks: u16,
    interrupted_s: f32,
    /// True while the latest mean is another one.
    pub is_changed: bool,
}

impl RestRate {
    /// All zero, for a static.
    pub const fn new() -> Self {
        const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
        Self { mean: ZERO, variance: 0.0, latest: ZERO, scatter: 0.0, blocks: 0, interrupted_s: 0.0, is_changed: false }
    }

    /// Passes over seconds in which the gyro was not quiet. After a jerk it goes on; after a motion it begins anew.
    pub fn interrupt(&mut self, time_s: f32) {
        self.interrupted_s += time_s;
        if self.interrupted_s > JERK_S {
            *self = Self::new();
        }
    }

    /// Takes the mean rate of a block, rad/s. Returns true if the rate has just changed.
    pub fn update(&mut self, rate: &Vector3<f32>) -> bool {
        let was_changed = self.is_changed;
        self.interrupted_s = 0.0;
        self.blocks += if self.blocks < MOST { 1 } else { 0 };
        let n = f32::from(self.blocks);
        let off = rate - self.mean;
        let memory = if n < LATEST { n } else { LATEST };
        if self.blocks == 1 {
            self.variance = UNKNOWN;
        } else {
            // The latest mean varies by a `memory`-th of a block's variance or less.
            let square = (off - self.latest).norm_squared() / 3.0 * (1.0 - 1.0 / n);
            self.scatter += (square - self.scatter) / (n - 1.0);
        }
        self.latest += (off - self.latest) / memory;
        if self.blocks < LEAST {
            return false;
        }
        let variance = self.variance + self.scatter / if n < LIKE { n } else { LIKE };
        self.is_changed = self.latest.norm_squared() > IN_A_MILLION * variance;
        if !self.is_changed {
            // The scatter of the latest mean, so that the first blocks of a change hardly enter.
            let floor = self.scatter / f32::from(MOST);
            let gain = self.variance / (self.variance + self.scatter);
            let part = self.latest * gain;
            self.mean += part;
            self.latest -= part;
            self.variance *= 1.0 - gain;
            self.variance = if self.variance > floor { self.variance } else { floor };
        }
        self.is_changed && !was_changed
    }

    /// Change of the rate, rad/s, across a direction of unit length, which it turns.
    pub fn across(&self, direction: &Vector3<f32>) -> f32 {
        libm::sqrtf(self.latest.cross(direction).norm_squared())
    }

    /// Takes the latest mean as the one from which a change counts.
    pub fn accept(&mut self) {
        self.mean += self.latest;
        self.variance = self.scatter / LIKE;
        self.latest = Vector3::zeros();
        self.is_changed = false;
    }
}

#[cfg(test)]
mod tests;
