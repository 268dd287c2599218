//! Reward: exchange of members variable by variable (paper, eq 20 to 23).

use crate::optimizer::{SearchSpace, population::Population, random::uniform};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Largest believable distance of a parabola's bottom, in steps; beyond it three costs give only the
/// direction.
const REACH: f32 = 8.0;

/// Least difference of a step from 1 that is worth an evaluation: the remaining gain goes with its square.
const SAME_STEP: f32 = 0.2;

/// Use of the costs of a variable's two trials.
#[derive(Clone, Copy, Debug)]
enum Rule<const D: usize> {
    /// The bottom of the parabola decides.
    Parabola,
    /// The lower cost wins (eq 22 and 23); true where the partner has won.
    Points([bool; D]),
}

/// Exchange whose rewards are being evaluated (eq 20 to 23 in our reading): the two trials of one variable
/// after the other, each the best point with that variable replaced, then the candidate. Nothing else moves
/// meanwhile.
///
/// The best point replaces the least-squares estimate of eq 21, and equals it while nothing better is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange<const D: usize> {
    /// Best point when the exchange began, and its cost.
    base: [f32; D],
    cost: f32,
    /// Values of the variables in the two trials.
    trials: [[f32; D]; 2],
    /// Cost of the first trial of this variable.
    first: Option<f32>,
    variable: usize,
    rule: Rule<D>,
    candidate: [f32; D],
    /// Slope of the cost along the line from the base to the candidate, at the base.
    slope: f32,
}

impl<const D: usize> Exchange<D> {
    fn new<const N: usize>(population: &Population<D, N>, rule: Rule<D>) -> Self {
        let base = *population.member(population.best());
        let cost = population.cost(population.best());
        Self { base, cost, trials: [base; 2], first: None, variable: 0, rule, candidate: base, slope: 0.0 }
    }

    /// Creates an exchange by [`super::Reward::Values`]: trials one `step` (in half widths of the box, at
    /// most 0.5) to either side of the best; where that leaves the box, both to the inner side.
    pub fn about_best<const N: usize>(space: &SearchSpace<D>, population: &Population<D, N>, step: f32) -> Self {
        let mut exchange = Self::new(population, Rule::Parabola);
        let [above, below] = &mut exchange.trials;
        let values = above.iter_mut().zip(below).zip(&exchange.base);
        for (((above, below), x), ((lower, upper), half)) in values.zip(space.bounds().zip(space.half_widths())) {
            let step = step * half;
            (*above, *below) = if x + step > upper {
                (x - step, x - 2.0 * step)
            } else if x - step < lower {
                (x + step, x + 2.0 * step)
            } else {
                (x + step, x - step)
            };
        }
        exchange
    }

    /// Creates an exchange by [`super::Reward::Points`]: the values of a member and of its partner.
    pub fn between<const N: usize>(population: &Population<D, N>, member: usize, partner: usize) -> Self {
        let mut exchange = Self::new(population, Rule::Points([false; D]));
        exchange.trials = [*population.member(member), *population.member(partner)];
        exchange
    }

    /// Next point to evaluate: a trial, the candidate, or the candidate at another step.
    pub fn next(&self) -> [f32; D] {
        if self.variable >= D {
            return self.candidate;
        }
        let mut x = self.base;
        let [first, second] = &self.trials;
        let values = if self.first.is_none() { first } else { second };
        if let (Some(x), Some(value)) = (x.get_mut(self.variable), values.get(self.variable)) {
            *x = *value;
        }
        x
    }

    /// Takes the cost of the point from [`Exchange::next`]. Returns true if the exchange continues.
    pub fn take(&mut self, cost: f32, generator: &mut Xoshiro128PlusPlus) -> bool {
        if self.variable >= D {
            return self.variable == D && self.take_candidate(cost);
        }
        let Some(first) = self.first.take() else {
            self.first = Some(cost);
            return true;
        };
        match &mut self.rule {
            Rule::Parabola => {
                let [a, b] = self.trials.map(|values| values.get(self.variable).copied().unwrap_or_default());
                if let (Some(x), Some(base)) = (self.candidate.get_mut(self.variable), self.base.get(self.variable)) {
                    let (offset, slope) = lowest(self.cost, (a - base, first), (b - base, cost));
                    *x = base + offset;
                    self.slope += slope * offset;
                }
            }
            Rule::Points(won) => {
                if let Some(won) = won.get_mut(self.variable) {
                    *won = cost < first;
                }
                if self.variable + 1 == D {
                    let [member, partner] = &self.trials;
                    self.candidate = exchanged(member, partner, won, generator);
                }
            }
        }
        self.variable += 1;
        true
    }

    /// Step of eq 20: where variables are coupled the candidate lies too far or too near, and slope and cost
    /// tell by how much. Returns true if another step is worth an evaluation.
    fn take_candidate(&mut self, cost: f32) -> bool {
        let curvature = cost - self.cost - self.slope;
        let step = -0.5 * self.slope / curvature;
        if !(curvature > 0.0 && step > 0.0 && libm::fabsf(step - 1.0) > SAME_STEP) {
            return false;
        }
        let step = if step < REACH { step } else { REACH };
        for (x, base) in self.candidate.iter_mut().zip(&self.base) {
            *x = base + step * (*x - base);
        }
        self.variable += 1;
        true
    }
}

/// Candidate by [`super::Reward::Free`]: the value nearer to the start wins in each variable.
pub(super) fn freely_exchanged<const D: usize>(
    member: &[f32; D],
    partner: &[f32; D],
    start: &[f32; D],
    generator: &mut Xoshiro128PlusPlus,
) -> [f32; D] {
    let mut won = [false; D];
    for (won, ((x, other), start)) in won.iter_mut().zip(member.iter().zip(partner).zip(start)) {
        *won = libm::fabsf(other - start) < libm::fabsf(x - start);
    }
    exchanged(member, partner, &won, generator)
}

/// Candidate of eq 20 and 22: towards the partner where it has won, by its share of the points.
fn exchanged<const D: usize>(
    member: &[f32; D],
    partner: &[f32; D],
    won: &[bool; D],
    generator: &mut Xoshiro128PlusPlus,
) -> [f32; D] {
    let share = won.iter().filter(|won| **won).count() as f32 / D as f32;
    let mut out = *member;
    for ((x, other), won) in out.iter_mut().zip(partner).zip(won) {
        if *won {
            *x += share * uniform(generator) * (other - *x);
        }
    }
    out
}

/// Bottom of the parabola through (0, `cost`) and two trials (offset, cost), and its slope at 0; where it
/// opens downwards, the lowest of the three points. A trial without a finite cost leaves 0 or the other
/// trial's offset.
fn lowest(cost: f32, (a, at_a): (f32, f32), (b, at_b): (f32, f32)) -> (f32, f32) {
    // Slopes of the two chords; slope s and curvature c: f(d) = cost + s d + c d^2.
    let (chord_a, chord_b) = ((at_a - cost) / a, (at_b - cost) / b);
    let curvature = (chord_a - chord_b) / (a - b);
    let slope = chord_a - curvature * a;
    let offset = -0.5 * slope / curvature;
    let reach = REACH * libm::fabsf(a);
    if !(curvature > 0.0 && offset.is_finite()) {
        let (offset, lower, chord) = if at_a < at_b { (a, at_a, chord_a) } else { (b, at_b, chord_b) };
        if lower < cost { (offset, chord) } else { (0.0, 0.0) }
    } else if offset > reach {
        (reach, slope)
    } else if offset >= -reach {
        (offset, slope)
    } else {
        (-reach, slope)
    }
}

#[cfg(test)]
mod tests;
