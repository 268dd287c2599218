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
    /// Its variance, of each axis, (rad/s)^2; unknown before the first blocks.
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
            // Of the latest mean, so that the first blocks of a change hardly enter.
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
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    const SIGMA_RAD_S: f32 = 4e-4;

    /// Nearly normal noise with [`SIGMA_RAD_S`] on each axis about a mean, rad/s.
    fn noisy(random: &mut Xoshiro128PlusPlus, mean: &Vector3<f32>) -> Vector3<f32> {
        let mut normal = || (0..12).map(|_| (random.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5).sum::<f32>();
        mean + Vector3::new(normal(), normal(), normal()) * SIGMA_RAD_S
    }

    #[test]
    fn noise_is_no_change_and_three_of_its_deviations_are_one_within_six_blocks() {
        let random = &mut Xoshiro128PlusPlus::seed_from_u64(3);
        let bias = Vector3::new(0.02, -0.01, 0.03);
        let mut rate = RestRate::new();
        let false_ones = (0..20_000).filter(|_| rate.update(&noisy(random, &bias))).count();
        assert!(false_ones <= 2 && (rate.mean - bias).norm() < SIGMA_RAD_S, "{false_ones} {}", rate.mean);
        let before = rate.mean;
        let other = bias + Vector3::new(0.0, 0.0, 4.0 * SIGMA_RAD_S);
        let seen = (0..20).position(|_| rate.update(&noisy(random, &other)));
        assert!(seen.is_some_and(|blocks| blocks < 6), "{seen:?}");
        // The mean stays that of before.
        assert!((rate.mean - before).norm() < 0.3 * SIGMA_RAD_S, "{}", rate.mean - before);
        (0..20).for_each(|_| _ = rate.update(&noisy(random, &other)));
        rate.accept();
        assert!(!rate.update(&noisy(random, &other)) && (rate.mean - other).norm() < 2.0 * SIGMA_RAD_S);
    }

    #[test]
    fn a_jerk_does_not_end_a_rest_and_a_motion_does() {
        let random = &mut Xoshiro128PlusPlus::seed_from_u64(4);
        let bias = Vector3::new(0.02, -0.01, 0.03);
        let turning = bias + Vector3::new(2e-3, 0.0, 0.0);
        for (interrupted_s, is_seen) in [(1.0, true), (10.0, false)] {
            let mut rate = RestRate::new();
            (0..40).for_each(|_| _ = rate.update(&noisy(random, &bias)));
            rate.interrupt(interrupted_s);
            assert_eq!((0..20).any(|_| rate.update(&noisy(random, &turning))), is_seen);
        }
    }
}
