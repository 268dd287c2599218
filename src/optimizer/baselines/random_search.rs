//! Random search, the lower bar for every method.

use super::incumbent::Incumbent;
use crate::optimizer::{Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost, random::uniform};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Random search: the start, then uniform draws from the box. Every method has to beat it.
#[derive(Clone, Debug)]
pub struct RandomSearch<const D: usize> {
    space: SearchSpace<D>,
    max_evaluations: u32,
    best: Incumbent<D>,
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize> RandomSearch<D> {
    /// Creates a search of `max_evaluations`, the start included.
    ///
    /// # Errors
    /// Rejects a space of no dimensions.
    pub fn new(space: &SearchSpace<D>, max_evaluations: u32, seed: u64) -> Result<Self, OptimizerError> {
        space.check()?;
        Ok(Self {
            space: *space,
            max_evaluations,
            best: Incumbent::new(space),
            evaluations: 0,
            generator: Xoshiro128PlusPlus::seed_from_u64(seed),
        })
    }
}

impl<const D: usize> Found<D> for RandomSearch<D> {
    fn best(&self) -> (&[f32; D], f32) {
        (&self.best.x, self.best.cost)
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<const D: usize, C: Cost<D> + ?Sized> Optimizer<C, D> for RandomSearch<D> {
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.max_evaluations {
            return Progress::Done;
        }
        let mut x = *self.space.start();
        if self.evaluations > 0 {
            for (x, (l, u)) in x.iter_mut().zip(self.space.bounds()) {
                *x = l + uniform(&mut self.generator) * (u - l);
            }
        }
        self.best.offer(&x, finite_cost(cost, &x));
        self.evaluations += 1;
        Progress::Running
    }
}
