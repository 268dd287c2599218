//! Rest, as the estimator judges it: two nodes in succession with a quiet gyro, a mean rate that a bias can be, and
//! vectors that do not turn. The attitude filter has its own, `attitude/rest.rs`.

use super::{
    preintegration::{Preintegration, largest, squared_angle},
    real::{Real, V3, norm, square, zero3},
    settings::Settings,
};

/// Shortest node that can be half of a rest, seconds.
const LEAST_S: f32 = 0.4;
/// A vector that turns by more in half a second turns: a degree.
const LEAST_TURN_RAD: f32 = 0.017;

/// Readings of a node; a vector without readings is zero.
#[derive(Clone, Copy)]
struct Half<T> {
    rate: V3<T>,
    variance: V3<T>,
    force: V3<T>,
    field: V3<T>,
}

/// The node before, as half of a rest.
#[derive(Clone, Copy)]
pub(super) struct Rests<T> {
    before: Option<Half<T>>,
    /// Mean raw rate of the two.
    pub rate: V3<T>,
    /// When the latest rest ended, microseconds; 0: there was none.
    pub latest_us: u64,
    /// The latest 64 seconds, one bit each, the newest lowest: 1 for rest. And what there is of the second in progress.
    history: u64,
    second_s: T,
    rest_s: T,
}

impl<T: Real> Rests<T> {
    pub const fn zero() -> Self {
        Self { before: None, rate: zero3(), latest_us: 0, history: 0, second_s: T::ZERO, rest_s: T::ZERO }
    }

    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Forgets the node before: the next one does not follow it.
    pub fn interrupt(&mut self) {
        self.before = None;
    }

    /// Returns the number of the last `seconds` (at most 64) that were at rest.
    pub fn seconds(&self, seconds: u32) -> u32 {
        let mask = if seconds >= 64 { u64::MAX } else { (1 << seconds) - 1 };
        (self.history & mask).count_ones()
    }

    /// Returns true if the node that ends, and the one before it, were at rest.
    pub fn judge(&mut self, pre: &Preintegration<T>, settings: &Settings) -> bool {
        let is_rest = self.is_rest(pre, settings);
        self.second_s += pre.seconds;
        if is_rest {
            self.rest_s += pre.seconds;
            self.latest_us = pre.end_us;
        }
        // A node may be shorter or longer than half a second.
        while self.second_s >= T::ONE {
            self.history = self.history << 1 | u64::from(self.rest_s + self.rest_s > self.second_s);
            self.second_s -= T::ONE;
            self.rest_s = T::ZERO;
        }
        is_rest
    }

    fn is_rest(&mut self, pre: &Preintegration<T>, settings: &Settings) -> bool {
        if pre.seconds < T::of(LEAST_S) {
            self.before = None;
            return false;
        }
        let (variance, rate) = pre.rate_statistics();
        let half = Half { rate, variance, force: pre.forces_read, field: pre.fields_read };
        let Some(before) = self.before.replace(half) else { return false };
        let part = T::of(0.5);
        let apart = (before.rate - half.rate) * part;
        let variance = (before.variance + half.variance) * part + apart.component_mul(&apart);
        let limit = T::of(settings.rest_deviation_rad_s);
        self.rate = (before.rate + half.rate) * part;
        let turned = |a: &V3<T>, b: &V3<T>| {
            let are_read = square(a) > T::ZERO && square(b) > T::ZERO;
            are_read && squared_angle(a, b) > T::of(LEAST_TURN_RAD * LEAST_TURN_RAD)
        };
        let quiet = largest(&variance) < limit * limit;
        quiet
            && norm(&self.rate) < T::of(settings.most_bias_rad_s)
            && !turned(&before.force, &half.force)
            && !turned(&before.field, &half.field)
    }
}
