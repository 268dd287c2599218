//! The mean norm of the field: a node that differs from it is disturbed.
//!
//! The paper's eq 8 refuses what errs by more than half; here what the norm errs by widens the field's noise.

use super::{preintegration::Preintegration, real::Real};

/// Nodes over which it is averaged: five minutes.
const NODES: u16 = 600;

/// Mean of the norms as they were calibrated at their time.
#[derive(Clone, Copy)]
pub(super) struct FieldNorm<T> {
    of_their_time: T,
    count: u16,
}

impl<T: Real> FieldNorm<T> {
    pub const fn zero() -> Self {
        Self { of_their_time: T::ZERO, count: 0 }
    }

    /// Adds a node; `share`: one over its increments with a field.
    pub fn add(&mut self, pre: &Preintegration<T>, share: T) {
        self.count = if self.count < NODES { self.count + 1 } else { NODES };
        self.of_their_time += (pre.field_norms * share - self.of_their_time) / T::of(f32::from(self.count));
    }

    /// The mean.
    pub fn of_their_time(&self) -> T {
        self.of_their_time
    }
}
