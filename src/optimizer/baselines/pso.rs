//! Particle swarm, one of the searches that IMOA is compared with.

#![allow(clippy::indexing_slicing)] // Particles are indexed by numbers reduced modulo the swarm.

use crate::optimizer::{
    Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost, population::Population, random::uniform,
};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Settings of [`Pso`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PsoSettings {
    /// Largest number of cost evaluations, the first positions included.
    pub max_evaluations: u32,
    /// Constriction, the factor of the whole velocity. Default 0.72984 (Clerc and Kennedy 2002, eq 4.15 for a
    /// sum of attractions of 4.1).
    pub constriction: f32,
    /// Attraction to the particle's own best place and to the swarm's. Default 2.05 each.
    pub attraction: f32,
}

impl PsoSettings {
    /// Creates settings with the published constants.
    #[must_use]
    pub const fn new(max_evaluations: u32) -> Self {
        Self { max_evaluations, constriction: 0.729_84, attraction: 2.05 }
    }
}

/// Particle swarm with constriction and a global best, `N` particles (Clerc and Kennedy, IEEE Trans. Evol.
/// Comput. 6 (2002) 58; Bratton and Kennedy, IEEE Swarm Intelligence Symposium 2007). Velocities begin at
/// zero; a particle that meets a wall stays there and loses its velocity across it.
#[derive(Clone, Debug)]
pub struct Pso<const D: usize, const N: usize> {
    space: SearchSpace<D>,
    settings: PsoSettings,
    /// Best places of the particles.
    population: Population<D, N>,
    positions: [[f32; D]; N],
    velocities: [[f32; D]; N],
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize, const N: usize> Pso<D, N> {
    /// Creates a swarm about the space's start.
    ///
    /// # Errors
    /// Rejects no particles or dimensions, and settings that are not finite.
    pub fn new(space: &SearchSpace<D>, settings: PsoSettings, seed: u64) -> Result<Self, OptimizerError> {
        if !(settings.constriction.is_finite() && settings.attraction.is_finite()) {
            return Err(OptimizerError::Setting("constriction or attraction"));
        }
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let population = Population::new(space, 1, &mut generator)?;
        let positions = core::array::from_fn(|index| *population.member(index));
        let velocities = [[0.0; D]; N];
        Ok(Self { space: *space, settings, population, positions, velocities, evaluations: 0, generator })
    }

    /// Moves a particle: v = chi (v + c u1 (own best - x) + c u2 (swarm's best - x)), x = x + v, with
    /// deviates per dimension.
    fn fly(&mut self, turn: usize) {
        let PsoSettings { constriction, attraction, .. } = self.settings;
        let (own, swarm) = (self.population.member(turn), self.population.member(self.population.best()));
        let mut to = self.positions[turn % N];
        for ((v, x), (own, swarm)) in self.velocities[turn % N].iter_mut().zip(&mut to).zip(own.iter().zip(swarm)) {
            let pull = uniform(&mut self.generator) * (own - *x) + uniform(&mut self.generator) * (swarm - *x);
            *v = constriction * (*v + attraction * pull);
            *x += *v;
        }
        let free = to;
        self.space.confine(&mut to);
        for ((v, free), x) in self.velocities[turn % N].iter_mut().zip(&free).zip(&to) {
            if free != x {
                *v = 0.0;
            }
        }
        self.positions[turn % N] = to;
    }
}

impl<const D: usize, const N: usize> Found<D> for Pso<D, N> {
    fn best(&self) -> (&[f32; D], f32) {
        self.population.lowest()
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: Cost<D> + ?Sized, const D: usize, const N: usize> Optimizer<C, D> for Pso<D, N> {
    /// Moves and evaluates one particle, particles in turn.
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.settings.max_evaluations {
            return Progress::Done;
        }
        let turn = self.evaluations as usize % N;
        if self.evaluations as usize >= N {
            self.fly(turn);
        }
        let x = self.positions[turn % N];
        self.population.offer(turn, x, finite_cost(cost, &x));
        self.evaluations += 1;
        Progress::Running
    }
}
