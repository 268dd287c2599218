//! Differential evolution, one of the searches that IMOA is compared with.

use crate::optimizer::{
    Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost, population::Population, random::uniform,
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Settings of [`DifferentialEvolution`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferentialEvolutionSettings {
    /// Largest number of cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// Weight F of the difference. Default 0.5 (Storn and Price 1997, section 5).
    pub weight: f32,
    /// Probability CR that a variable comes from the mutant. Default 0.9 (same source).
    pub crossover: f32,
}

impl DifferentialEvolutionSettings {
    /// Creates settings with the published constants.
    #[must_use]
    pub const fn new(max_evaluations: u32) -> Self {
        Self { max_evaluations, weight: 0.5, crossover: 0.9 }
    }
}

/// Differential evolution DE/rand/1/bin with `N` members (Storn and Price, J. Global Optimization 11 (1997)
/// 341). The published advice is 5 to 10 members a variable. A successor replaces its member at once, not at
/// the end of the generation.
#[derive(Clone, Debug)]
pub struct DifferentialEvolution<const D: usize, const N: usize> {
    space: SearchSpace<D>,
    settings: DifferentialEvolutionSettings,
    population: Population<D, N>,
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize, const N: usize> DifferentialEvolution<D, N> {
    /// Creates a population about the space's start.
    ///
    /// # Errors
    /// Rejects fewer than 4 members, no dimensions, and settings out of their range.
    pub fn new(
        space: &SearchSpace<D>,
        settings: DifferentialEvolutionSettings,
        seed: u64,
    ) -> Result<Self, OptimizerError> {
        if !(settings.weight.is_finite() && (0.0..=1.0).contains(&settings.crossover)) {
            return Err(OptimizerError::Setting("weight or crossover"));
        }
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let population = Population::new(space, 4, &mut generator)?;
        Ok(Self { space: *space, settings, population, evaluations: 0, generator })
    }

    /// Trial x_a + F (x_b - x_c), crossed with the member (eq 3 and 4 of the source).
    fn trial(&mut self, turn: usize) -> [f32; D] {
        let generator = &mut self.generator;
        // Three different others: draws without replacement from the N - 1 that follow.
        let count = if N > 3 { N - 1 } else { 3 };
        let a = generator.next_u32() as usize % count;
        let mut b = generator.next_u32() as usize % (count - 1);
        if b >= a {
            b += 1;
        }
        let mut c = generator.next_u32() as usize % (count - 2);
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        if c >= low {
            c += 1;
        }
        if c >= high {
            c += 1;
        }
        let [a, b, c] = [a, b, c].map(|hop| self.population.member(turn + 1 + hop));
        let parent = self.population.member(turn);
        let forced = generator.next_u32() as usize % if D == 0 { 1 } else { D };
        let mut trial = *parent;
        let sources = a.iter().zip(b).zip(c).zip(self.space.bounds());
        for (k, (x, (((a, b), c), (l, u)))) in trial.iter_mut().zip(sources).enumerate() {
            if uniform(generator) < self.settings.crossover || k == forced {
                let mutant = a + self.settings.weight * (b - c);
                // A variable that leaves the box ends half-way from the member to the wall.
                *x = if mutant > u {
                    0.5 * *x + 0.5 * u
                } else if mutant >= l {
                    mutant
                } else {
                    0.5 * *x + 0.5 * l
                };
            }
        }
        trial
    }
}

impl<const D: usize, const N: usize> Found<D> for DifferentialEvolution<D, N> {
    fn best(&self) -> (&[f32; D], f32) {
        self.population.lowest()
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: Cost<D> + ?Sized, const D: usize, const N: usize> Optimizer<C, D> for DifferentialEvolution<D, N> {
    /// Evaluates one member's trial, members in turn.
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.settings.max_evaluations {
            return Progress::Done;
        }
        let turn = self.evaluations as usize % N;
        let x = if (self.evaluations as usize) < N { *self.population.member(turn) } else { self.trial(turn) };
        self.population.offer(turn, x, finite_cost(cost, &x));
        self.evaluations += 1;
        Progress::Running
    }
}
