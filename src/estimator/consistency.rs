//! Consistency of the filter with itself: its squared innovations against what it says of their size.

use super::{real::Real, remainder::INNOVATIONS};

/// Degrees of freedom of a node: its rows less its states.
const FREEDOM: f32 = 9.0;
/// NIS, mean squared innovation over its degrees of freedom, of a filter that has diverged: four deviations over 1 for
/// the mean of 120 nodes with nine degrees each. Sound runs stay under 1.07.
pub(super) const DIVERGED: f32 = 1.2;
/// Excess of NIS over 1 that means divergence before there are so many nodes: this over the root of their number.
const DIVERGED_EARLY: f32 = 1.9;

#[derive(Clone, Copy)]
pub(super) struct Consistency<T> {
    /// Mean of the latest nodes' squared innovations over their degrees of freedom.
    mean: T,
    /// Number of these nodes.
    latest: u16,
    /// Squared innovations of all nodes that neither globals nor effects can explain.
    unexplained: T,
    /// Number of all nodes.
    nodes: u32,
}

impl<T: Real> Consistency<T> {
    pub const fn zero() -> Self {
        Self { mean: T::ZERO, latest: 0, unexplained: T::ZERO, nodes: 0 }
    }

    /// Adds a node's squared innovation.
    pub fn add(&mut self, square: T) {
        self.latest = if self.latest < INNOVATIONS { self.latest + 1 } else { INNOVATIONS };
        self.mean += (square / T::of(FREEDOM) - self.mean) / T::of(f32::from(self.latest));
    }

    /// Adds the part of a node's squared innovation that effects leave, too.
    pub fn add_unexplained(&mut self, square: T) {
        self.unexplained += square;
        self.nodes = self.nodes.saturating_add(1);
    }

    /// NIS of the latest nodes: mean squared innovation over its degrees of freedom.
    pub fn nis(&self) -> f32 {
        self.mean.narrow()
    }

    /// NIS of all nodes, if the effects leave the sum of squares `left` beside the part that none can explain.
    pub fn nis_beside(&self, left: T) -> f32 {
        let freedom = if self.nodes > 0 { T::of(FREEDOM * self.nodes as f32) } else { T::ONE };
        ((self.unexplained + left) / freedom).narrow()
    }

    /// True before the first node.
    pub const fn is_empty(&self) -> bool {
        self.latest == 0
    }

    /// Returns true if the innovations are too large for the filter to be right.
    pub fn has_diverged(&self) -> bool {
        self.latest >= INNOVATIONS && self.mean > T::of(DIVERGED)
    }

    /// Returns true if the innovations are too large; after few nodes with a wider limit.
    pub fn seems_diverged(&self) -> bool {
        let early = 1.0 + DIVERGED_EARLY / libm::sqrtf(f32::from(self.latest));
        self.has_diverged() || self.nis() > DIVERGED && self.nis() > early
    }
}
