//! Population of a search.

#![allow(clippy::indexing_slicing)] // Members are indexed by numbers reduced modulo the population.

use super::{OptimizerError, SearchSpace, random::normal};
use rand_core::Rng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Population of points with their costs, and the index of the lowest.
#[derive(Clone, Debug)]
pub(super) struct Population<const D: usize, const N: usize> {
    members: [[f32; D]; N],
    costs: [f32; N],
    best: usize,
}

impl<const D: usize, const N: usize> Population<D, N> {
    /// Creates the first population (eq 9, about the start): the start itself and normal deviates, none
    /// evaluated yet.
    pub fn new(
        space: &SearchSpace<D>,
        needed: usize,
        generator: &mut Xoshiro128PlusPlus,
    ) -> Result<Self, OptimizerError> {
        space.check()?;
        if N < needed || N == 0 {
            return Err(OptimizerError::PopulationTooSmall { needed });
        }
        let mut members = [*space.start(); N];
        for member in members.iter_mut().skip(1) {
            for (x, half) in member.iter_mut().zip(space.half_widths()) {
                *x += half * (space.deviation() * normal(generator));
            }
            space.confine(member);
        }
        Ok(Self { members, costs: [f32::INFINITY; N], best: 0 })
    }

    /// Returns a member; the remainder shows the compiler that the index is in range.
    pub fn member(&self, index: usize) -> &[f32; D] {
        &self.members[index % N]
    }

    pub fn cost(&self, index: usize) -> f32 {
        self.costs[index % N]
    }

    pub const fn best(&self) -> usize {
        self.best
    }

    /// Returns the best member and its cost.
    pub fn lowest(&self) -> (&[f32; D], f32) {
        (self.member(self.best), self.cost(self.best))
    }

    pub fn worst(&self) -> usize {
        (0..N).fold(0, |worst, index| if self.cost(index) > self.cost(worst) { index } else { worst })
    }

    /// Moves a member whatever its new cost.
    #[cfg(any(test, feature = "baseline-searches"))]
    pub fn replace(&mut self, index: usize, x: [f32; D], cost: f32) {
        self.members[index % N] = x;
        self.costs[index % N] = cost;
        self.best = (0..N).fold(0, |best, index| if self.cost(index) < self.cost(best) { index } else { best });
    }

    /// Moves a member only to a better place. Returns true if it moved.
    pub fn offer(&mut self, index: usize, x: [f32; D], cost: f32) -> bool {
        let better = cost < self.cost(index);
        if better {
            if cost < self.cost(self.best) {
                self.best = index;
            }
            self.members[index % N] = x;
            self.costs[index % N] = cost;
        }
        better
    }

    /// Draws another member than `index`, uniformly.
    pub fn other(&self, index: usize, generator: &mut Xoshiro128PlusPlus) -> usize {
        if N < 2 {
            return index;
        }
        let hop = 1 + generator.next_u32() as usize % (N - 1);
        (index + hop) % N
    }
}
