//! Guided spiral, the global phase (paper, eq 19).

use crate::optimizer::{
    population::Population,
    random::{cosine_of_turn, uniform},
};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Global phase, eq 19 in our reading. The member moves towards the best by the guiding factor b = F_best /
/// F_i in [0, 1] times a uniform deviate from (0, 2) per variable, plus a spiral of (1 - b)^2 e^b cos(2 pi a)
/// of the distance, which closes as the member becomes as good as the best. Without the deviate every member
/// falls onto the best once b is near 1, and the population is lost.
pub(super) fn guided_spiral<const D: usize, const N: usize>(
    population: &Population<D, N>,
    turn: usize,
    generator: &mut Xoshiro128PlusPlus,
) -> [f32; D] {
    let (own, lowest) = (population.cost(turn), population.cost(population.best()));
    let guide = if own.is_finite() && own > 0.0 && lowest >= 0.0 { lowest / own } else { 0.0 };
    // e^b for b in [0, 1] to 0.3 %, enough for the spiral's width.
    let exponential = 1.0 + guide * (1.013 + guide * (0.4255 + 0.2797 * guide));
    let spiral = (1.0 - guide) * (1.0 - guide) * exponential;
    let mut moved = *population.member(turn);
    for (x, best) in moved.iter_mut().zip(population.member(population.best())) {
        let distance = best - *x;
        let step = 2.0 * uniform(generator) * guide;
        *x += step * distance + spiral * cosine_of_turn(uniform(generator)) * libm::fabsf(distance);
    }
    moved
}

#[cfg(test)]
mod tests;
