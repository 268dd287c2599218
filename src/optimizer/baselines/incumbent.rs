//! Lowest point so far of a search that may leave it.

use crate::optimizer::SearchSpace;

/// Lowest point evaluated so far, for searches whose members may move to worse places.
#[derive(Clone, Debug)]
pub(super) struct Incumbent<const D: usize> {
    pub x: [f32; D],
    pub cost: f32,
}

impl<const D: usize> Incumbent<D> {
    pub const fn new(space: &SearchSpace<D>) -> Self {
        Self { x: *space.start(), cost: f32::INFINITY }
    }

    pub const fn offer(&mut self, x: &[f32; D], cost: f32) {
        if cost < self.cost {
            self.x = *x;
            self.cost = cost;
        }
    }
}
