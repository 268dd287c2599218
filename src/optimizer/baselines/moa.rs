//! MOA, the meerkat optimisation algorithm that the paper improves, as printed.

use super::incumbent::Incumbent;
use crate::optimizer::{
    Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost,
    population::Population,
    random::{normal, uniform},
};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Settings of [`Moa`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoaSettings {
    /// Largest number of cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// Probability of the global phase (eq 10 and 11) over the local one (eq 12 and 13). Default 0.5.
    pub hunting: f32,
    /// Probability of a random exploration (eq 14) after a member's move. Default 0.3, the published
    /// sentry's.
    pub sentry: f32,
}

impl MoaSettings {
    /// Creates settings with the published constants.
    #[must_use]
    pub const fn new(max_evaluations: u32) -> Self {
        Self { max_evaluations, hunting: 0.5, sentry: 0.3 }
    }
}

/// Next piece of the search, for the member whose turn it is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Move,
    /// Eq 13, after eq 12 found nothing better.
    Flee,
    /// Exploration of eq 14.
    Explore,
}

/// Meerkat optimisation as the paper prints it (eq 9 to 14, after Xian and Feng, Expert Systems with
/// Applications 231 (2023) 120482), with `N` members: a named baseline.
///
/// X_i cancels in eq 12 and the operators are drawn to the origin, so the result depends on the origin of the
/// coordinates. Only eq 12 is greedy; the best place is remembered apart. Variables that leave the box are
/// drawn anew. Where the print is open: r and rand are uniform from [0, 1), one for all variables; X_i^0 in
/// eq 10 is the member's first place.
#[derive(Clone, Debug)]
pub struct Moa<const D: usize, const N: usize> {
    space: SearchSpace<D>,
    settings: MoaSettings,
    population: Population<D, N>,
    /// First population, the directions of eq 10.
    first: Population<D, N>,
    best: Incumbent<D>,
    turn: usize,
    stage: Stage,
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize, const N: usize> Moa<D, N> {
    /// Creates a population about the space's start.
    ///
    /// # Errors
    /// Rejects no members or dimensions, and settings out of their range.
    pub fn new(space: &SearchSpace<D>, settings: MoaSettings, seed: u64) -> Result<Self, OptimizerError> {
        if !((0.0..=1.0).contains(&settings.hunting) && (0.0..=1.0).contains(&settings.sentry)) {
            return Err(OptimizerError::Setting("hunting or sentry"));
        }
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let population = Population::new(space, 1, &mut generator)?;
        Ok(Self {
            space: *space,
            settings,
            first: population.clone(),
            population,
            best: Incumbent::new(space),
            turn: 0,
            stage: Stage::Move,
            evaluations: 0,
            generator,
        })
    }

    /// Step of eq 10: (1 - t / T) r.
    fn step_length(&mut self) -> f32 {
        let time = self.evaluations as f32 / self.settings.max_evaluations as f32;
        (1.0 - time) * uniform(&mut self.generator)
    }

    /// Move of eq 10 or 11, equally likely.
    fn hunt(&mut self) -> [f32; D] {
        let step = self.step_length();
        let mut x = *self.population.member(self.turn);
        if uniform(&mut self.generator) < 0.5 {
            // Eq 10: X_i + step X_i^0.
            for (x, direction) in x.iter_mut().zip(self.first.member(self.turn)) {
                *x += step * direction;
            }
        } else {
            // Eq 11: X_i + step (X_j - (rand + 0.5) X_i).
            let partner = self.population.other(self.turn, &mut self.generator);
            let own = uniform(&mut self.generator) + 0.5;
            for (x, other) in x.iter_mut().zip(self.population.member(partner)) {
                *x += step * (other - own * *x);
            }
        }
        x
    }

    /// Move of eq 12: X_i + (2 rand X_gb - X_i), in which X_i cancels.
    fn fight(&mut self) -> [f32; D] {
        let scale = 2.0 * uniform(&mut self.generator);
        self.best.x.map(|best| scale * best)
    }

    /// Move of eq 13: div X_i - (2 rand X_gb - X_i), div = rand + 0.1.
    fn flee(&mut self) -> [f32; D] {
        let deviation = uniform(&mut self.generator) + 0.1;
        let scale = 2.0 * uniform(&mut self.generator);
        let mut x = *self.population.member(self.turn);
        for (x, best) in x.iter_mut().zip(&self.best.x) {
            *x = deviation * *x - (scale * best - *x);
        }
        x
    }

    /// Move of eq 14: X_i + (2 rand - 1) (X_i + rand s) step, s a Levy flight.
    fn explore(&mut self) -> [f32; D] {
        let step = self.step_length();
        let sign = 2.0 * uniform(&mut self.generator) - 1.0;
        let flight = uniform(&mut self.generator);
        let mut x = *self.population.member(self.turn);
        for x in &mut x {
            *x += sign * (*x + flight * levy(&mut self.generator)) * step;
        }
        x
    }
}

impl<const D: usize, const N: usize> Found<D> for Moa<D, N> {
    fn best(&self) -> (&[f32; D], f32) {
        (&self.best.x, self.best.cost)
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: Cost<D> + ?Sized, const D: usize, const N: usize> Optimizer<C, D> for Moa<D, N> {
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.settings.max_evaluations {
            return Progress::Done;
        }
        let first = (self.evaluations as usize) < N;
        let mut fighting = false;
        let mut x = match self.stage {
            _ if first => *self.population.member(self.turn),
            Stage::Move if uniform(&mut self.generator) < self.settings.hunting => self.hunt(),
            Stage::Move => {
                fighting = true;
                self.fight()
            }
            Stage::Flee => self.flee(),
            Stage::Explore => self.explore(),
        };
        self.space.redraw(&mut x, &mut self.generator);
        let found = finite_cost(cost, &x);
        self.evaluations += 1;
        self.best.offer(&x, found);
        if !fighting {
            self.population.replace(self.turn, x, found);
        } else if !self.population.offer(self.turn, x, found) {
            self.stage = Stage::Flee;
            return Progress::Running;
        }
        let explores = !first && self.stage != Stage::Explore && uniform(&mut self.generator) < self.settings.sentry;
        self.stage = if explores { Stage::Explore } else { Stage::Move };
        if !explores {
            self.turn = (self.turn + 1) % N;
        }
        Progress::Running
    }
}

/// Levy flight of exponent 1.5 by Mantegna's method (Phys. Rev. E 49 (1994) 4677): u / |v|^(2/3), u and v
/// normal, the deviation of u 0.6966. May be infinite.
fn levy(generator: &mut Xoshiro128PlusPlus) -> f32 {
    let u = 0.696_574_5 * normal(generator);
    let v = libm::fabsf(normal(generator));
    u / libm::expf(2.0 / 3.0 * libm::logf(v))
}
