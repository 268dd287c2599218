//! A share of the latest time.

use super::real::Real;

/// Latest time that a share is taken over, seconds.
const OF_S: f32 = 50.0;

/// Running mean: over all time at first, later over the last 50 s or so.
#[derive(Clone, Copy)]
pub(super) struct Share<T> {
    value: T,
    seconds: T,
}

impl<T: Real> Share<T> {
    pub const fn zero() -> Self {
        Self { value: T::ZERO, seconds: T::ZERO }
    }

    /// Adds `seconds` in which the value was `now`.
    pub fn add(&mut self, now: T, seconds: T) {
        let seconds_so_far = self.seconds + seconds;
        self.seconds = if seconds_so_far < T::of(OF_S) { seconds_so_far } else { T::of(OF_S) };
        let part = if seconds < self.seconds { seconds / self.seconds } else { T::ONE };
        self.value += (now - self.value) * part;
    }

    pub fn get(&self) -> f32 {
        self.value.narrow()
    }
}

/// Shares of time that show that a sensor is of no use.
#[derive(Clone, Copy)]
pub(super) struct Shares<T> {
    /// Share of the latest time whose rates entered no node.
    pub unread: Share<T>,
    /// Share of the latest motion whose rates contradict the field.
    pub turned: Share<T>,
    /// Share of the latest motion that has no field.
    pub fieldless: Share<T>,
}

impl<T: Real> Shares<T> {
    pub const fn zero() -> Self {
        Self { unread: Share::zero(), turned: Share::zero(), fieldless: Share::zero() }
    }
}

#[cfg(test)]
mod tests;
