//! Step length of the trials (paper, eq 16 to 18).

use crate::optimizer::{SearchSpace, population::Population};

/// Least and largest step, relative to the first population's deviation. Below, f32's rounding of a window's
/// cost drowns the parabola; above, one far member would stretch the step over the box.
const LEAST: f32 = 0.5;
const MOST: f32 = 2.0;

/// Step length, eq 15 to 18 in our reading: (1 + a_h) r, in half widths of the box.
///
/// The distance r of the worst from the best member (eq 17) is a root mean square over the variables. As
/// printed the step is a_h r; a_h, the relative error of a norm, is a few thousandths in clean data, so the
/// search would stand still just where its cost can be trusted. Here clean data (a_h = 0) leave the step at
/// r, and disturbed data lengthen it.
pub(super) fn step_length<const D: usize, const N: usize>(
    space: &SearchSpace<D>,
    population: &Population<D, N>,
    disturbance: f32,
) -> f32 {
    let (best, worst) = (population.member(population.best()), population.member(population.worst()));
    let spread = relative_distance(space, best, worst) * (1.0 + if disturbance < 1.0 { disturbance } else { 1.0 });
    let (least, most) = (held(LEAST * space.deviation()), held(MOST * space.deviation()));
    if spread > most {
        most
    } else if spread >= least {
        spread
    } else {
        least
    }
}

/// Limits a step to half a half width, so that two trials fit into the box on either side of any point.
pub(super) const fn held(step: f32) -> f32 {
    if step > 0.5 { 0.5 } else { step }
}

/// Root mean square of the distance over the variables, each in half widths of the box, so that different
/// units add up.
pub(super) fn relative_distance<const D: usize>(space: &SearchSpace<D>, a: &[f32; D], b: &[f32; D]) -> f32 {
    let mut square = 0.0;
    for ((a, b), half) in a.iter().zip(b).zip(space.half_widths()) {
        square += (a - b) / half * ((a - b) / half);
    }
    libm::sqrtf(square / D as f32)
}

#[cfg(test)]
mod tests;
