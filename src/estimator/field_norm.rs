//! Norm of the field that is read, against its usual value: a node whose norm differs is disturbed.
//!
//! The paper's eq 8 refuses a field that errs by more than half; here the error of the norm inflates the field's noise.

use super::{preintegration::Preintegration, real::Real};

/// Nodes over which the norm is averaged: five minutes.
const NODES: u16 = 600;

/// Means over the nodes whose field was used.
#[derive(Clone, Copy)]
pub(super) struct FieldNorm<T> {
    of_their_time: T,
    scatter: T,
    count: u16,
    /// Fields that an increment has, on the mean of the nodes with any.
    read: T,
}

impl<T: Real> FieldNorm<T> {
    pub const fn zero() -> Self {
        Self { of_their_time: T::ZERO, scatter: T::ZERO, count: 0, read: T::ZERO }
    }

    /// Returns true if a node with any field has too few for its mean: less than half of the usual. The first is usual.
    /// A magnetometer may be slower than the increments.
    pub fn has_too_few(&mut self, pre: &Preintegration<T>) -> bool {
        let [fields, increments] = [pre.fields, pre.increments].map(|count| T::of(f32::from(count)));
        self.read += (fields / increments - self.read) / T::of(f32::from(self.count) + 1.0);
        fields + fields < self.read * increments
    }

    /// Adds a node; `share`: one over its increments with a field.
    pub fn add(&mut self, pre: &Preintegration<T>, share: T) {
        self.count = if self.count < NODES { self.count + 1 } else { NODES };
        let part = T::ONE / T::of(f32::from(self.count));
        self.of_their_time += (pre.field_norms * share - self.of_their_time) * part;
        self.scatter += (pre.field_variance() - self.scatter) * part;
    }

    /// Mean norm of the read field, each node's calibrated as it was at its time.
    pub fn of_their_time(&self) -> T {
        self.of_their_time
    }

    /// Variance of a node's mean field by its readings' scatter; `None` before the first.
    pub fn scatter(&self) -> Option<T> {
        (self.count > 0).then_some(self.scatter)
    }
}

#[cfg(test)]
mod tests;
