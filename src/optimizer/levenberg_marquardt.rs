//! Levenberg-Marquardt, for costs that are sums of squares.

use super::{Cost, Found, Optimizer, Progress, finite_cost};
use crate::algebra::Packed;

/// Cost that is a sum of (robust) squares, so that it has normal equations.
///
/// `T` is D (D + 1) / 2, the size of the packed matrix.
pub trait LeastSquaresCost<const D: usize, const T: usize>: Cost<D> {
    /// Writes the (re-weighted) Gauss-Newton matrix at `x` and the direction of descent, so that `normal step
    /// = descent`.
    fn normal_equations(&self, x: &[f32; D], normal: &mut Packed<D, T>, descent: &mut [f32; D]);
}

/// Levenberg-Marquardt search (Marquardt, J. SIAM 11 (1963) 431) with Marquardt's scaling: damping times the
/// diagonal, a tenth on success, tenfold on failure. It has no bounds.
///
/// The search ends when a step gains under 1e-6 of the cost, when no damping helps, or when the start has no finite
/// cost.
#[derive(Clone, Copy, Debug)]
pub struct LevenbergMarquardt<const D: usize, const T: usize> {
    x: [f32; D],
    cost: f32,
    damping: f32,
    max_evaluations: u32,
    evaluations: u32,
    done: bool,
}

impl<const D: usize, const T: usize> LevenbergMarquardt<D, T> {
    /// Creates a search from `start` with at most `max_evaluations` of the cost, the start's included; each
    /// but the first also takes one set of normal equations.
    #[must_use]
    pub const fn new(start: [f32; D], max_evaluations: u32) -> Self {
        Self { x: start, cost: f32::INFINITY, damping: 1e-3, max_evaluations, evaluations: 0, done: false }
    }
}

impl<const D: usize, const T: usize> Found<D> for LevenbergMarquardt<D, T> {
    fn best(&self) -> (&[f32; D], f32) {
        (&self.x, self.cost)
    }

    fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

impl<C: LeastSquaresCost<D, T> + ?Sized, const D: usize, const T: usize> Optimizer<C, D> for LevenbergMarquardt<D, T> {
    /// Evaluates the start, then one trial step a call: one set of normal equations, one solve, one
    /// evaluation.
    fn step(&mut self, cost: &C) -> Progress {
        if self.done || self.evaluations >= self.max_evaluations || self.damping > 1e6 {
            self.done = true;
            return Progress::Done;
        }
        if self.evaluations == 0 {
            self.cost = finite_cost(cost, &self.x);
            self.evaluations = 1;
            self.done = !self.cost.is_finite();
            return if self.done { Progress::Done } else { Progress::Running };
        }
        let mut normal = Packed::zero();
        let mut descent = [0.0; D];
        cost.normal_equations(&self.x, &mut normal, &mut descent);
        for i in 0..D {
            let diagonal = normal.get(i, i);
            normal.add(i, i, self.damping * diagonal);
        }
        let Some(factor) = normal.cholesky() else {
            self.damping *= 10.0;
            return Progress::Running;
        };
        let step = factor.solve(&descent);
        let mut candidate = self.x;
        for (x, s) in candidate.iter_mut().zip(&step) {
            *x += s;
        }
        let found = finite_cost(cost, &candidate);
        self.evaluations += 1;
        if found < self.cost {
            // A gain under 1e-6 of the cost is f32's noise in a sum over a window.
            self.done = self.cost - found < 1e-6 * libm::fabsf(self.cost);
            self.x = candidate;
            self.cost = found;
            self.damping *= 0.1;
        } else {
            self.damping *= 10.0;
        }
        if self.done { Progress::Done } else { Progress::Running }
    }
}
