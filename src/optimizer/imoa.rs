#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Members are indexed by numbers reduced modulo the population.

use super::{
    Cost, Progress,
    random::{cosine_of_turn, normal, uniform},
};
use core::f32::consts::FRAC_PI_2;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// How the search runs. The defaults are those that reached the optimum with the fewest evaluations on simulated windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImoaSettings {
    /// Most cost evaluations, the first population included.
    pub max_evaluations: u32,
    /// Standard deviation of the first population about the start, in units of the box's half width.
    pub deviation: f32,
    /// Exchange between members by per-dimension reward (eq 20 to 23, the free form) in the global phase.
    pub reward: bool,
    /// Per-dimension refraction (eq 26 to 29) of each new member.
    pub refraction: bool,
}

impl ImoaSettings {
    pub const fn new(max_evaluations: u32) -> Self {
        Self { max_evaluations, deviation: 0.1, reward: false, refraction: false }
    }
}

/// Improved meerkat optimisation algorithm, in our reading of the paper's equations, in the box [-1, 1]^D about a start at 0.
///
/// In whitened coordinates the start is the least-squares point, so "nearer to the least-squares estimate in the information
/// metric", which decides the free reward of eq 20 to 23, is "nearer to 0 in that coordinate".
#[derive(Clone, Debug)]
pub(crate) struct Imoa<const D: usize, const POPULATION: usize> {
    members: [[f32; D]; POPULATION],
    costs: [f32; POPULATION],
    best: usize,
    evaluations: u32,
    generator: Option<Xoshiro128PlusPlus>,
}

impl<const D: usize, const POPULATION: usize> Imoa<D, POPULATION> {
    pub const fn zero() -> Self {
        Self { members: [[0.0; D]; POPULATION], costs: [0.0; POPULATION], best: 0, evaluations: 0, generator: None }
    }

    /// First population (eq 9, centred): the start itself and normal deviates about it.
    pub fn start(&mut self, settings: &ImoaSettings, seed: u64) {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        for (index, member) in self.members.iter_mut().enumerate() {
            for x in member.iter_mut() {
                *x = if index == 0 { 0.0 } else { into_box(settings.deviation * normal(&mut generator)) };
            }
        }
        self.costs = [f32::INFINITY; POPULATION];
        self.best = 0;
        self.evaluations = 0;
        self.generator = Some(generator);
    }

    /// One cost evaluation: a member of the first population, then one new candidate a call, members in turn.
    pub fn step(&mut self, cost: &impl Cost<D>, settings: &ImoaSettings) -> Progress {
        let Some(mut generator) = self.generator.take() else { return Progress::Done };
        if self.evaluations >= settings.max_evaluations {
            return Progress::Done;
        }
        let turn = self.evaluations as usize % POPULATION;
        let first = (self.evaluations as usize) < POPULATION;
        let candidate = if first { *self.member(turn) } else { self.candidate(turn, settings, &mut generator) };
        let found = cost.evaluate(&candidate);
        self.evaluations += 1;
        // Greedy: a member moves only to a better place. NaN compares false, so it is never taken.
        if found < self.cost(turn) {
            if found < self.cost(self.best) {
                self.best = turn;
            }
            self.members[turn % POPULATION] = candidate;
            self.costs[turn % POPULATION] = found;
        }
        self.generator = Some(generator);
        Progress::Running
    }

    fn candidate(&self, turn: usize, settings: &ImoaSettings, generator: &mut Xoshiro128PlusPlus) -> [f32; D] {
        let progress = self.evaluations as f32 / settings.max_evaluations as f32;
        // The global and the local phase are equally likely (MOA: P = 0.5).
        let mut candidate = if uniform(generator) < 0.5 {
            let moved = self.guided_spiral(turn, generator);
            if settings.reward { self.exchanged(&moved, turn, generator) } else { moved }
        } else {
            self.migration(turn, progress, generator)
        };
        if settings.refraction {
            refract(&mut candidate, progress, generator);
        }
        candidate.map(into_box)
    }

    /// Global phase, eq 19 in our reading: towards the best by the guiding factor b = F_best / F_i in [0, 1] times a uniform
    /// deviate from (0, 2) per dimension, with a spiral of (1 - b)^2 e^b cos(2 pi a) of the distance, which closes as the member
    /// becomes as good as the best. Without the deviate every member falls onto the best as soon as b is near 1, and the
    /// population is lost.
    fn guided_spiral(&self, turn: usize, generator: &mut Xoshiro128PlusPlus) -> [f32; D] {
        let own = self.cost(turn);
        let guide = if own.is_finite() && own > 0.0 { self.cost(self.best) / own } else { 0.0 };
        // e^b for b in [0, 1] to 0.3 %: the spiral's width needs no more.
        let exponential = 1.0 + guide * (1.013 + guide * (0.4255 + 0.2797 * guide));
        let spiral = (1.0 - guide) * (1.0 - guide) * exponential;
        let mut moved = *self.member(turn);
        for (x, best) in moved.iter_mut().zip(self.member(self.best)) {
            let distance = best - *x;
            let step = 2.0 * uniform(generator) * guide;
            *x += step * distance + spiral * cosine_of_turn(uniform(generator)) * libm::fabsf(distance);
        }
        moved
    }

    /// Exchange, eq 20 to 23 with the free reward: each dimension goes to the member that is nearer to the start in it, and
    /// the candidate moves towards the partner by the partner's share of the rewards.
    fn exchanged(&self, moved: &[f32; D], turn: usize, generator: &mut Xoshiro128PlusPlus) -> [f32; D] {
        let partner = self.member(self.other(turn, generator));
        let wins = moved.iter().zip(partner).filter(|(a, b)| libm::fabsf(**b) < libm::fabsf(**a)).count();
        let share = wins as f32 / D as f32;
        let mut out = *moved;
        for (x, other) in out.iter_mut().zip(partner) {
            if libm::fabsf(*other) < libm::fabsf(*x) {
                *x += share * uniform(generator) * (other - *x);
            }
        }
        out
    }

    /// Local phase, eq 24 and 25 in our reading: normal deviates about the best, as wide as the member's distance from it per
    /// dimension (in 30 % of draws its root mean square over the dimensions), narrowing with time to 0.3.
    fn migration(&self, turn: usize, progress: f32, generator: &mut Xoshiro128PlusPlus) -> [f32; D] {
        // The best itself has no distance from the best: it borrows another member's.
        let from = if turn == self.best { self.other(turn, generator) } else { turn };
        let best = self.member(self.best);
        let width = 0.3 + 0.7 * (1.0 - quarter_sine(progress));
        let isotropic = uniform(generator) < 0.3;
        let mut square = 0.0;
        for (x, b) in self.member(from).iter().zip(best) {
            square += (x - b) * (x - b);
        }
        let rms = libm::sqrtf(square / D as f32);
        let mut out = *best;
        for (x, own) in out.iter_mut().zip(self.member(from)) {
            let distance = if isotropic { rms } else { libm::fabsf(own - *x) };
            *x += width * normal(generator) * distance;
        }
        out
    }

    /// Another member than `turn`, uniformly.
    fn other(&self, turn: usize, generator: &mut Xoshiro128PlusPlus) -> usize {
        if POPULATION < 2 {
            return turn;
        }
        let hop = 1 + generator.next_u32() as usize % (POPULATION - 1);
        (turn + hop) % POPULATION
    }

    pub fn best(&self) -> (&[f32; D], f32) {
        (self.member(self.best), self.cost(self.best))
    }

    /// A member; the remainder lets the compiler see that the index is in range.
    fn member(&self, index: usize) -> &[f32; D] {
        &self.members[index % POPULATION]
    }

    fn cost(&self, index: usize) -> f32 {
        self.costs[index % POPULATION]
    }

    pub const fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

/// Refraction, eq 26 to 29 in our reading: with probability 0.3 + 0.7 p, p = 1 - exp(-(2 t / T)^2 / 2), one dimension is
/// mirrored about the start and shrunk by a ratio from (1, 10).
fn refract<const D: usize>(candidate: &mut [f32; D], progress: f32, generator: &mut Xoshiro128PlusPlus) {
    let p = 1.0 - libm::expf(-2.0 * progress * progress);
    if uniform(generator) < 0.3 + 0.7 * p {
        let dimension = generator.next_u32() as usize % D;
        let ratio = 1.0 + 9.0 * uniform(generator);
        candidate[dimension] = -candidate[dimension] / ratio;
    }
}

/// sin(pi x / 2) for x in [0, 1], Taylor series to the 7th order, error under 2e-4.
fn quarter_sine(x: f32) -> f32 {
    let a = FRAC_PI_2 * x;
    let a2 = a * a;
    a * (1.0 - a2 * (1.0 / 6.0 - a2 * (1.0 / 120.0 - a2 * (1.0 / 5_040.0))))
}

/// Members that leave the box are put on its wall.
#[expect(clippy::manual_clamp, reason = "f32::clamp differs from the chip's in the sign of zero")]
fn into_box(x: f32) -> f32 {
    if x > 1.0 {
        1.0
    } else if x < -1.0 {
        -1.0
    } else {
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bowl whose lowest point is off the start; in whitened coordinates every window looks like this near its optimum.
    struct Bowl {
        lowest: [f32; 12],
        nan: bool,
    }

    impl Cost<12> for Bowl {
        fn evaluate(&self, x: &[f32; 12]) -> f32 {
            let square: f32 = x.iter().zip(&self.lowest).map(|(a, b)| (a - b) * (a - b)).sum();
            if self.nan && square > 0.5 { f32::NAN } else { 100.0 + 50.0 * square }
        }
    }

    fn search(settings: &ImoaSettings, seed: u64, nan: bool) -> f32 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed + 77);
        let cost = Bowl { lowest: [0.0; 12].map(|_: f32| 0.1 * normal(&mut generator)), nan };
        let mut imoa = Imoa::<12, 12>::zero();
        imoa.start(settings, seed);
        while imoa.step(&cost, settings) == Progress::Running {}
        assert_eq!(imoa.evaluations(), settings.max_evaluations);
        imoa.best().1
    }

    #[test]
    fn a_bowl_is_searched_to_a_hundredth_in_300_evaluations_from_every_seed() {
        for seed in 0..60 {
            assert!(search(&ImoaSettings::new(300), seed, false) < 101.0, "seed {seed}");
        }
    }

    #[test]
    fn the_papers_other_operators_search_too_and_nan_is_never_taken() {
        for seed in 0..20 {
            let all = ImoaSettings { reward: true, refraction: true, ..ImoaSettings::new(1000) };
            assert!(search(&all, seed, false) < 102.0, "seed {seed}");
            assert!(search(&ImoaSettings::new(300), seed, true).is_finite());
        }
    }
}
