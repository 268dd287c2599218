//! IMOA as the paper prints it, to compare with our reading.

use super::incumbent::Incumbent;
use crate::optimizer::{
    Cost, Found, Optimizer, OptimizerError, Progress, SearchSpace, finite_cost,
    population::Population,
    random::{cosine_of_turn, uniform},
};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Settings of [`ImoaLiteral`]. The two that the paper takes from the sensors are constants here: a rotation
/// does not change a norm, so neither depends on the candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImoaLiteralSettings {
    /// Largest number of cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// Relative error a_h of the norm of `(1 - [w]x dt) a` in eq 15 and 16. Default 0.0055: sqrt(1 + (w
    /// dt)^2) - 1 at 180 deg/s and 30 Hz, where `a` is perpendicular to `w`. The norm is the same whichever sign eq 15
    /// has.
    pub modulus_error: f32,
    /// Guide beta of eq 19, |g| / |g_hat| in [0, 1]. Default 1.
    pub guide: f32,
}

impl ImoaLiteralSettings {
    /// Creates settings for the paper's turntable.
    #[must_use]
    pub const fn new(max_evaluations: u32) -> Self {
        Self { max_evaluations, modulus_error: 0.0055, guide: 1.0 }
    }
}

/// Next piece of the search, for the member whose turn it is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// Move by eq 19, or eq 12.
    Move,
    /// Rewards of eq 22 and 23, variable by variable: the member's value in the least-squares estimate, then
    /// the partner's.
    Reward { variable: usize, own: Option<f32> },
    /// Exchange of eq 20.
    Exchange,
    /// Migration of eq 24 and 25.
    Migrate,
    /// Refraction of eq 26 to 29, from this variable on.
    Refract(usize),
}

/// Improved meerkat optimisation as printed (eq 15 to 29, as literally as they can be executed), with `N`
/// members: a named baseline, never the default. [`Imoa`](crate::optimizer::Imoa) is the reading that works.
///
/// The least-squares estimate of eq 21 is the space's start. A reward (eq 20 to 23) takes 2 D evaluations, a
/// refraction one a variable. The global and the local phase are equally likely. Eq 28 only restates eq 27,
/// so the ratio is drawn from (1, 10). Variables that leave the box are drawn anew.
#[derive(Clone, Debug)]
pub struct ImoaLiteral<const D: usize, const N: usize> {
    space: SearchSpace<D>,
    settings: ImoaLiteralSettings,
    population: Population<D, N>,
    best: Incumbent<D>,
    turn: usize,
    /// Rounds over the population, t of eq 26.
    round: u32,
    stage: Stage,
    partner: usize,
    /// Rewards T_m of the member and of its partner (eq 22).
    rewards: [u32; 2],
    evaluations: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const D: usize, const N: usize> ImoaLiteral<D, N> {
    /// Creates a population about the space's start.
    ///
    /// # Errors
    /// Rejects no members or dimensions, and settings out of their range.
    pub fn new(space: &SearchSpace<D>, settings: ImoaLiteralSettings, seed: u64) -> Result<Self, OptimizerError> {
        if !(settings.modulus_error.is_finite() && (0.0..=1.0).contains(&settings.guide)) {
            return Err(OptimizerError::Setting("modulus_error or guide"));
        }
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let population = Population::new(space, 1, &mut generator)?;
        Ok(Self {
            space: *space,
            settings,
            population,
            best: Incumbent::new(space),
            turn: 0,
            round: 0,
            stage: Stage::Move,
            partner: 0,
            rewards: [0; 2],
            evaluations: 0,
            generator,
        })
    }

    /// Step of eq 17 and 18: a_h times the distance of the worst from the best member.
    fn step_length(&self) -> f32 {
        let (worst, best) =
            (self.population.member(self.population.worst()), self.population.member(self.population.best()));
        self.settings.modulus_error * distance(worst, best)
    }

    /// Guided spiral of eq 19: X_i + step [(1 - beta)^2 e^beta cos(2 pi alpha) + beta X_gb].
    fn guided_spiral(&mut self) -> [f32; D] {
        let (step, guide) = (self.step_length(), self.settings.guide);
        let spiral = (1.0 - guide) * (1.0 - guide) * libm::expf(guide) * cosine_of_turn(uniform(&mut self.generator));
        let mut x = *self.population.member(self.turn);
        for (x, best) in x.iter_mut().zip(&self.best.x) {
            *x += step * (spiral + guide * best);
        }
        x
    }

    /// Exchange of eq 20: X_i + step (T_j / D_m X_j - T_i / D_m X_i), D_m = T_i + T_j of the member i and its partner
    /// j.
    fn exchange(&self) -> [f32; D] {
        let step = self.step_length();
        let [own, other] = self.rewards.map(|reward| reward as f32);
        let mut x = *self.population.member(self.turn);
        // Eq 23 gives at least one of the two a point in every variable, so the sum is not zero.
        for (x, partner) in x.iter_mut().zip(self.population.member(self.partner)) {
            *x += step * (other * partner - own * *x) / (own + other);
        }
        x
    }

    /// Least-squares estimate with one variable taken from a member (eq 23).
    fn estimate_with(&self, variable: usize, member: usize) -> [f32; D] {
        let mut x = *self.space.start();
        if let (Some(x), Some(value)) = (x.get_mut(variable), self.population.member(member).get(variable)) {
            *x = *value;
        }
        x
    }

    /// Move of eq 12.
    fn towards_best(&mut self) -> [f32; D] {
        let scale = 2.0 * uniform(&mut self.generator);
        self.best.x.map(|best| scale * best)
    }

    /// Migration of eq 24 and 25: [1 - sin(2 t / T)] div X_i - (2 rand X_gb - X_i), div = |X_i - X_gb|.
    fn migrate(&mut self) -> [f32; D] {
        let time = self.evaluations as f32 / self.settings.max_evaluations as f32;
        let scale = 2.0 * uniform(&mut self.generator);
        let mut x = *self.population.member(self.turn);
        let factor = (1.0 - libm::sinf(2.0 * time)) * distance(&x, &self.best.x);
        for (x, best) in x.iter_mut().zip(&self.best.x) {
            *x = factor * *x - (scale * best - *x);
        }
        x
    }

    /// Finds the next variable from `from` on that eq 26 refracts. Returns it, and the member with it
    /// refracted.
    fn refraction(&mut self, from: usize) -> Option<(usize, [f32; D])> {
        // Bounds of eq 29: over all variables, whatever their units.
        let (mut upper, mut lower) = (f32::NEG_INFINITY, f32::INFINITY);
        for x in self.space.start() {
            upper = if *x > upper { *x } else { upper };
            lower = if *x < lower { *x } else { lower };
        }
        let worst = *self.population.member(self.population.worst());
        let best = *self.population.member(self.population.best());
        let mut x = *self.population.member(self.turn);
        for (variable, ((x_k, worst), best)) in x.iter_mut().zip(&worst).zip(&best).enumerate().skip(from) {
            // Eq 26: 1 - exp(-[t / X_worst - X_best]^2) / 2.
            let ratio = self.round as f32 / worst - best;
            let probability = 1.0 - 0.5 * libm::expf(-ratio * ratio);
            if uniform(&mut self.generator) < probability {
                // Eq 27: (UB + LB) / 2 + (UB + LB) / (2 eta) - X / eta.
                let middle = 0.5 * (upper + lower);
                let eta = 1.0 + 9.0 * uniform(&mut self.generator);
                *x_k = middle + middle / eta - *x_k / eta;
                return Some((variable, x));
            }
        }
        None
    }

    fn end_turn(&mut self) {
        self.stage = Stage::Move;
        self.turn = (self.turn + 1) % N;
        if self.turn == 0 {
            self.round = self.round.saturating_add(1);
        }
    }

    /// Evaluates a candidate, with variables outside the box drawn anew.
    fn evaluate<C: Cost<D> + ?Sized>(&mut self, cost: &C, x: &mut [f32; D]) -> f32 {
        self.space.redraw(x, &mut self.generator);
        let found = finite_cost(cost, x);
        self.evaluations += 1;
        self.best.offer(x, found);
        found
    }
}

fn distance<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f32 {
    libm::sqrtf(a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b)))
}

impl<const D: usize, const N: usize> Found<D> for ImoaLiteral<D, N> {
    fn best(&self) -> (&[f32; D], f32) {
        (&self.best.x, self.best.cost)
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: Cost<D> + ?Sized, const D: usize, const N: usize> Optimizer<C, D> for ImoaLiteral<D, N> {
    fn step(&mut self, cost: &C) -> Progress {
        if self.evaluations >= self.settings.max_evaluations {
            return Progress::Done;
        }
        if (self.evaluations as usize) < N {
            let mut x = *self.population.member(self.turn);
            let found = self.evaluate(cost, &mut x);
            self.population.replace(self.turn, x, found);
            self.end_turn();
            return Progress::Running;
        }
        if let Stage::Refract(from) = self.stage {
            if let Some((variable, mut x)) = self.refraction(from) {
                let found = self.evaluate(cost, &mut x);
                self.population.offer(self.turn, x, found);
                self.stage = Stage::Refract(variable + 1);
                return Progress::Running;
            }
            self.end_turn();
        }
        match self.stage {
            Stage::Reward { variable, own } => {
                let mut x = self.estimate_with(variable, if own.is_none() { self.turn } else { self.partner });
                let found = self.evaluate(cost, &mut x);
                self.stage = match own {
                    None => Stage::Reward { variable, own: Some(found) },
                    Some(own) => {
                        // Eq 23 gives each a point if they are equal.
                        let [mine, others] = &mut self.rewards;
                        *mine += u32::from(own <= found);
                        *others += u32::from(found <= own);
                        if variable + 1 < D {
                            Stage::Reward { variable: variable + 1, own: None }
                        } else {
                            Stage::Exchange
                        }
                    }
                };
            }
            Stage::Exchange => {
                let mut x = self.exchange();
                let found = self.evaluate(cost, &mut x);
                self.population.replace(self.turn, x, found);
                self.stage = Stage::Refract(0);
            }
            Stage::Migrate => {
                let mut x = self.migrate();
                let found = self.evaluate(cost, &mut x);
                self.population.replace(self.turn, x, found);
                self.stage = Stage::Refract(0);
            }
            Stage::Move | Stage::Refract(_) if uniform(&mut self.generator) < 0.5 => {
                let mut x = self.guided_spiral();
                let found = self.evaluate(cost, &mut x);
                self.population.replace(self.turn, x, found);
                self.partner = self.population.other(self.turn, &mut self.generator);
                self.rewards = [0; 2];
                self.stage = Stage::Reward { variable: 0, own: None };
            }
            Stage::Move | Stage::Refract(_) => {
                let mut x = self.towards_best();
                let found = self.evaluate(cost, &mut x);
                let moved = self.population.offer(self.turn, x, found);
                self.stage = if moved { Stage::Refract(0) } else { Stage::Migrate };
            }
        }
        Progress::Running
    }
}
