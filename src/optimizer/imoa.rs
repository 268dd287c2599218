//! IMOA, the improved meerkat optimisation algorithm, in our reading of the paper (docs/equations.md).

mod guided_spiral;
mod migration;
mod refraction;
mod reward;
mod settings;
mod step_length;

use super::{
    Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost, population::Population, random::uniform,
};
use guided_spiral::guided_spiral;
use migration::migration;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use refraction::refracted;
use reward::{Exchange, freely_exchanged};
pub use settings::{ImoaSettings, Reward};
use step_length::{held, step_length};

/// Next piece of the search.
#[derive(Clone, Copy, Debug)]
enum Stage<const D: usize> {
    /// Candidate of the member whose turn it is.
    Move,
    /// Refraction of one variable of the same member.
    Refract,
    /// Evaluation of rewards, or of the candidate that they make.
    Exchange(Exchange<D>),
}

/// Improved meerkat optimisation algorithm with `N` members, in our reading of the paper's equations.
///
/// Members move in turn, each by the global or the local phase with equal probability: guided spiral (eq 19)
/// or migration (eq 24 and 25), followed by refraction (eq 26 to 29) if switched on. After the first
/// population and then after every `N` moves one member exchanges by evaluated rewards (eq 20 to 23), which
/// takes 2 D + 1 evaluations, or one more, one a step. Every move is greedy: a member moves only to a better
/// place. The guiding factor is a ratio of costs, so the cost should be positive.
///
/// [`Reward::Values`] reads a parabola in each variable from its evaluations, so the coordinates should be
/// whitened ([`SearchSpace::UNIT`] about the least-squares point); it alone makes the search quick there. On
/// simulated windows (settings chosen on seeds 0 to 19, checked on 100 to 119, three inclinations; `cargo mwd
/// bench`, section evaluations) 180 of 180 searches from the least-squares point are within 1 % of the
/// optimum's cost after 50 evaluations, and within 0.1 posterior deviations of it after 100. One member does
/// as well as twelve, and twelve without the exchange reach 171 of 180 at 150. The population is for costs
/// with more than one minimum, where one member stays in the nearest.
#[derive(Clone, Debug)]
pub struct Imoa<const D: usize, const N: usize> {
    space: SearchSpace<D>,
    settings: ImoaSettings,
    population: Population<D, N>,
    stage: Stage<D>,
    turn: usize,
    /// Moves since the last exchange by evaluated rewards.
    moves: usize,
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize, const N: usize> Imoa<D, N> {
    /// Creates a population about the space's start (eq 9, centred).
    ///
    /// # Errors
    /// Rejects no members or dimensions, and settings out of their range.
    pub fn new(space: &SearchSpace<D>, settings: ImoaSettings, seed: u64) -> Result<Self, OptimizerError> {
        settings.check()?;
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let population = Population::new(space, 1, &mut generator)?;
        // An exchange follows the first population.
        Ok(Self {
            space: *space,
            settings,
            population,
            stage: Stage::Move,
            turn: 0,
            moves: N,
            evaluations: 0,
            generator,
        })
    }

    /// Share of the evaluations used, t / T.
    fn progress(&self) -> f32 {
        self.evaluations as f32 / self.settings.max_evaluations as f32
    }

    fn candidate(&mut self) -> [f32; D] {
        let progress = self.progress();
        let Self { space, settings, population, turn, generator, .. } = self;
        // Global and local phase are equally likely (MOA: P = 0.5).
        let global = uniform(generator) < 0.5;
        if !settings.migration || (settings.spiral && global) {
            let moved = guided_spiral(population, *turn, generator);
            if settings.reward != Reward::Free {
                return moved;
            }
            let partner = population.other(*turn, generator);
            freely_exchanged(&moved, population.member(partner), space.start(), generator)
        } else {
            migration(space, population, *turn, progress, generator)
        }
    }

    /// Returns the exchange that is due, if the evaluations suffice to finish it.
    fn exchange(&mut self) -> Option<Exchange<D>> {
        let left = self.settings.max_evaluations.saturating_sub(self.evaluations) as usize;
        if self.moves < N || left <= 2 * D {
            return None;
        }
        let Self { space, settings, population, turn, generator, .. } = self;
        match settings.reward {
            Reward::Off | Reward::Free => None,
            Reward::Points => Some(Exchange::between(population, *turn, population.other(*turn, generator))),
            Reward::Values => {
                let adaptive = settings.adaptive_step;
                let step = if adaptive {
                    step_length(space, population, settings.disturbance)
                } else {
                    held(space.deviation())
                };
                Some(Exchange::about_best(space, population, step))
            }
        }
    }

    /// Evaluates a point, to which the member whose turn it is moves if it costs less. Returns the cost.
    fn evaluate<C: Cost<D> + ?Sized>(&mut self, cost: &C, mut x: [f32; D]) -> f32 {
        self.space.confine(&mut x);
        let found = finite_cost(cost, &x);
        self.population.offer(self.turn, x, found);
        self.evaluations += 1;
        found
    }

    const fn end_turn(&mut self) {
        self.stage = Stage::Move;
        self.turn = (self.turn + 1) % if N == 0 { 1 } else { N };
    }
}

impl<const D: usize, const N: usize> Found<D> for Imoa<D, N> {
    fn best(&self) -> (&[f32; D], f32) {
        self.population.lowest()
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: Cost<D> + ?Sized, const D: usize, const N: usize> Optimizer<C, D> for Imoa<D, N> {
    /// Evaluates a member of the first population, then one trial or candidate a call.
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.settings.max_evaluations {
            return Progress::Done;
        }
        if (self.evaluations as usize) < N {
            self.evaluate(cost, *self.population.member(self.turn));
            self.end_turn();
            return Progress::Running;
        }
        if let Stage::Refract = self.stage {
            let progress = self.progress();
            let member = self.population.member(self.turn);
            let refracted = refracted(member, self.space.start(), progress, &mut self.generator);
            if let Some(x) = refracted {
                self.evaluate(cost, x);
            }
            self.end_turn();
            if refracted.is_some() {
                return Progress::Running;
            }
        }
        if let Stage::Move = self.stage
            && let Some(exchange) = self.exchange()
        {
            self.stage = Stage::Exchange(exchange);
            self.moves = 0;
        }
        if let Stage::Exchange(mut exchange) = self.stage {
            let found = self.evaluate(cost, exchange.next());
            if exchange.take(found, &mut self.generator) {
                self.stage = Stage::Exchange(exchange);
            } else {
                self.end_turn();
            }
        } else {
            let candidate = self.candidate();
            self.evaluate(cost, candidate);
            self.moves = self.moves.saturating_add(1);
            if self.settings.refraction {
                self.stage = Stage::Refract;
            } else {
                self.end_turn();
            }
        }
        Progress::Running
    }
}

#[cfg(test)]
mod tests;
