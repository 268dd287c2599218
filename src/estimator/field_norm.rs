//! Norm of the field that is read, against its usual value: a node whose norm differs is disturbed.
//!
//! The paper's eq 8 refuses a field that errs by more than half; here the error of the norm widens the field's noise.

use super::{preintegration::Preintegration, real::Real};

/// Nodes over which the norm is averaged: five minutes.
const NODES: u16 = 600;

/// Means over the nodes whose field was used.
#[derive(Clone, Copy)]
pub(super) struct FieldNorm<T> {
    of_their_time: T,
    scatter: T,
    count: u16,
}

impl<T: Real> FieldNorm<T> {
    pub const fn zero() -> Self {
        Self { of_their_time: T::ZERO, scatter: T::ZERO, count: 0 }
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
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_the_first_nodes_is_theirs() {
        let mut norms = FieldNorm::<f64>::zero();
        assert_eq!(norms.scatter(), None);
        for norm in [0.9, 1.1, 1.3] {
            let mut pre = Preintegration::zero();
            pre.field_norms = 4.0 * norm;
            norms.add(&pre, 0.25);
        }
        assert!((norms.of_their_time() - 1.1).abs() < 1e-12);
    }
}
