use super::{Cost, Progress};
use crate::algebra::Packed;

/// A cost that is a sum of (robust) squares, so that it has normal equations.
pub(crate) trait LeastSquaresCost<const D: usize, const T: usize>: Cost<D> {
    /// Writes the (re-weighted) Gauss-Newton matrix at `x` and the direction of descent, so that `normal step = descent`.
    fn normal_equations(&self, x: &[f32; D], normal: &mut Packed<D, T>, descent: &mut [f32; D]);
}

/// Levenberg-Marquardt with Marquardt's scaling: damping times the diagonal, tenfold down on success, up on failure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevenbergMarquardt<const D: usize> {
    x: [f32; D],
    cost: f32,
    damping: f32,
    evaluations: u32,
    done: bool,
}

impl<const D: usize> LevenbergMarquardt<D> {
    pub const fn zero() -> Self {
        Self { x: [0.0; D], cost: 0.0, damping: 0.0, evaluations: 0, done: false }
    }

    pub fn start(&mut self, x: [f32; D], cost: f32) {
        *self = Self { x, cost, damping: 1e-3, evaluations: 0, done: !cost.is_finite() };
    }

    /// One trial step: one set of normal equations, one solve, one evaluation.
    pub fn step<const T: usize>(&mut self, cost: &impl LeastSquaresCost<D, T>, max_evaluations: u32) -> Progress {
        if self.done || self.evaluations >= max_evaluations || self.damping > 1e6 {
            self.done = true;
            return Progress::Done;
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
        let found = cost.evaluate(&candidate);
        self.evaluations += 1;
        if found < self.cost {
            // A gain under 1e-6 of the cost is f32's noise of a sum over a window.
            self.done = self.cost - found < 1e-6 * self.cost;
            self.x = candidate;
            self.cost = found;
            self.damping *= 0.1;
        } else {
            self.damping *= 10.0;
        }
        if self.done { Progress::Done } else { Progress::Running }
    }

    pub const fn best(&self) -> (&[f32; D], f32) {
        (&self.x, self.cost)
    }

    pub const fn evaluations(&self) -> u32 {
        self.evaluations
    }
}
