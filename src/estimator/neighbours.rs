//! An increment between its neighbours: they give it the derivatives of specific force and rate.

use super::{
    increment::Increment,
    real::{Real, V3, zero3},
};
use heapless::Vec;

/// Increment that waits for its successor, and force and rate of its predecessor.
pub(super) struct Neighbours<T> {
    // Not an `Option`: that would not be all zero bytes.
    held: Vec<Increment<T>, 1>,
    force_before: Option<V3<T>>,
    rate_before: Option<V3<T>>,
}

impl<T: Real> Neighbours<T> {
    pub const fn none() -> Self {
        Self { held: Vec::new(), force_before: None, rate_before: None }
    }

    /// Forgets the predecessor: the next increment follows none.
    pub const fn forget_before(&mut self) {
        (self.force_before, self.rate_before) = (None, None);
    }

    /// Increment that waits for its successor.
    pub fn held(&self) -> Option<&Increment<T>> {
        self.held.first()
    }

    pub fn take(&mut self) -> Option<Increment<T>> {
        self.held.pop()
    }

    /// Holds an increment; the one before it has been taken.
    pub fn hold(&mut self, increment: Increment<T>) {
        self.held.clear();
        // Just emptied, so there is room.
        let _ = self.held.push(increment);
    }

    /// Derivatives of force and of rate at an increment, from the one before it and the next.
    pub fn derivatives(&mut self, at: &Increment<T>, next: Option<&Increment<T>>) -> [V3<T>; 2] {
        let between = at.seconds + at.seconds;
        let after = next.and_then(|next| next.force);
        let before = core::mem::replace(&mut self.force_before, at.force);
        let of_force = match (before, at.force, after) {
            (Some(before), _, Some(after)) => (after - before) / between,
            (None, Some(now), Some(after)) => (after - now) / at.seconds,
            (Some(before), Some(now), None) => (now - before) / at.seconds,
            _ => zero3(),
        };
        let of_rate = match (self.rate_before.replace(at.rate), next) {
            (Some(before), Some(next)) => (next.rate - before) / between,
            (None, Some(next)) => (next.rate - at.rate) / at.seconds,
            (Some(before), None) => (at.rate - before) / at.seconds,
            (None, None) => zero3(),
        };
        [of_force, of_rate]
    }
}
