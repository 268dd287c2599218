//! Migration, the local phase (paper, eq 24 and 25).

use super::step_length::relative_distance;
use crate::optimizer::{
    SearchSpace,
    population::Population,
    random::{normal, uniform},
};
use core::f32::consts::FRAC_PI_2;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Local phase, eq 24 and 25 in our reading (in place of eq 12 and 13): normal deviates about the best. Their
/// width is the member's distance from the best per variable (in 30 % of draws its root mean square over the
/// variables, eq 25), narrowing with time to 0.3. `progress` is t / T.
pub(super) fn migration<const D: usize, const N: usize>(
    space: &SearchSpace<D>,
    population: &Population<D, N>,
    turn: usize,
    progress: f32,
    generator: &mut Xoshiro128PlusPlus,
) -> [f32; D] {
    // The best has no distance from itself, so that another member's is taken.
    let from = population.member(if turn == population.best() { population.other(turn, generator) } else { turn });
    let best = population.member(population.best());
    let width = 0.3 + 0.7 * (1.0 - quarter_sine(progress));
    let isotropic = uniform(generator) < 0.3;
    let rms = relative_distance(space, from, best);
    let mut out = *best;
    for ((x, own), half) in out.iter_mut().zip(from).zip(space.half_widths()) {
        let distance = if isotropic { rms * half } else { libm::fabsf(own - *x) };
        *x += width * normal(generator) * distance;
    }
    out
}

/// Sine of pi x / 2 for x in [0, 1], Taylor series to the 7th order, error under 2e-4.
fn quarter_sine(x: f32) -> f32 {
    let a = FRAC_PI_2 * x;
    let a2 = a * a;
    a * (1.0 - a2 * (1.0 / 6.0 - a2 * (1.0 / 120.0 - a2 * (1.0 / 5_040.0))))
}

#[cfg(test)]
mod tests;
