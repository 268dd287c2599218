//! What the search of a window minimises: the filter's own quadratic, but with Student's t in the place of the Gaussian for each node as a whole.
//!
//! It stands in the place of the paper's eq 5, the angle between gravity dead-reckoned over the window and the measured specific force,
//! which cannot see a rotation about gravity and in drilling is blind.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    Estimator,
    left_over::{COLUMNS, LeftOver, ROWS},
    real::Real,
};
use crate::{
    algebra::{Cholesky, Packed, dot},
    compensation::GyroModel,
    optimizer::{Cost, LeastSquaresCost},
};

/// P and b.
const GYRO: usize = COLUMNS - 1;
/// Freedom of Student's t of a node, 5, and its rows: the squared innovation at which a node has half of its weight.
const SPREAD: f32 = 5.0 + ROWS as f32;

/// Weight of a node with this squared innovation.
fn weight(square: f32) -> f32 {
    SPREAD / (SPREAD + square)
}

/// What makes the cost one about the posterior's mean.
#[derive(Clone, Copy)]
pub(super) struct Centre {
    /// The mean, in units of the prior's widths.
    mean: [f32; GYRO],
    /// Of the posterior's information.
    factor: Cholesky<12, 78>,
    /// Share of the rows' information that is in the posterior's whatever the inflation.
    share: f32,
    /// Mean weight of the nodes at the mean.
    usual: f32,
}

impl Centre {
    /// Of a posterior with this covariance, inflated by `inflation` at most; `None` where that is not positive definite.
    pub fn new(rows: &LeftOver, mean: &[f32; GYRO], covariance: &[f32; 78], inflation: f32) -> Option<Self> {
        let covariance = Packed::<12, 78>(*covariance).cholesky()?;
        let mut information = Packed::zero();
        for i in 0..GYRO {
            let mut unit = [0.0; GYRO];
            unit[i] = 1.0;
            for (j, value) in covariance.solve(&unit).iter().enumerate().take(i + 1) {
                information.add(i, j, *value);
            }
        }
        let weights = (0..rows.count()).fold(0.0, |sum, index| {
            let innovations = rows.innovations(index, mean);
            sum + weight(dot(&innovations, &innovations))
        });
        let usual = if rows.count() > 0 { weights / rows.count() as f32 } else { 1.0 };
        information.cholesky().map(|factor| Self { mean: *mean, factor, share: 1.0 / inflation, usual })
    }
}

/// Cost of a change of (P row-major, b) from the posterior's mean, in posterior deviations. Half the squared distance, which is the posterior
/// with all that is older than the rows and with how far it was shrunk; and for each node of the window what a heavier tail changes of it:
/// s / 2 log(1 + |e|^2 / s) - u |e|^2 / 2, s = nu + 9, u the mean weight of the nodes there, times the share of the rows' information that the
/// posterior surely has. What the search then finds is what weights change that differ from node to node, and nothing else: of nodes that
/// are all as quiet, or all as noisy, the mean is the optimum.
pub struct WindowCost<'a> {
    rows: &'a LeftOver,
    centre: &'a Centre,
    /// Factory's P and the prior's mean of b, and the widths.
    base: GyroModel,
    sigma: [f32; GYRO],
}

impl<T: Real> Estimator<T> {
    /// The rows of the last 50 s of motion: what the population search minimises. `None` before a posterior, or without motion.
    #[must_use]
    pub fn window_cost(&self) -> Option<WindowCost<'_>> {
        let centre = self.centre.first().filter(|_| !self.posterior.is_empty())?;
        let base = self.model(&[T::ZERO; GYRO]);
        let mut sigma = [0.0; GYRO];
        let unit = self.model(&[T::ONE; GYRO]);
        let p = unit.p.as_flattened().iter().zip(base.p.as_flattened());
        let b = unit.b_rad_s.iter().zip(&base.b_rad_s);
        for (slot, (unit, base)) in sigma.iter_mut().zip(p.chain(b)) {
            *slot = unit - base;
        }
        Some(WindowCost { rows: &self.left_over, centre, base, sigma })
    }
}

impl WindowCost<'_> {
    fn change(&self, y: &[f32; GYRO]) -> [f32; GYRO] {
        self.centre.factor.solve_upper(y)
    }

    /// The model that lies `y` from the posterior's mean, in deviations.
    #[must_use]
    pub fn model(&self, y: &[f32; GYRO]) -> GyroModel {
        let change = self.change(y);
        let mut model = self.base;
        let slots = model.p.as_flattened_mut().iter_mut().chain(&mut model.b_rad_s);
        for (((slot, mean), change), sigma) in slots.zip(&self.centre.mean).zip(change).zip(&self.sigma) {
            *slot += (mean + change) * sigma;
        }
        model
    }

    /// Where a model lies.
    #[must_use]
    pub fn coordinates(&self, model: &GyroModel) -> [f32; GYRO] {
        let mut change = [0.0; GYRO];
        let p = model.p.as_flattened().iter().zip(self.base.p.as_flattened());
        let b = model.b_rad_s.iter().zip(&self.base.b_rad_s);
        for (((slot, (x, base)), mean), sigma) in
            change.iter_mut().zip(p.chain(b)).zip(&self.centre.mean).zip(&self.sigma)
        {
            *slot = (x - base) / sigma - mean;
        }
        self.centre.factor.times_upper(&change)
    }

    /// Visits the nodes with the squared innovations at `change`.
    fn squares(&self, change: &[f32; GYRO]) -> impl Iterator<Item = (usize, [f32; ROWS], f32)> {
        let mut x = self.centre.mean;
        for (x, change) in x.iter_mut().zip(change) {
            *x += change;
        }
        (0..self.rows.count()).map(move |index| {
            let innovations = self.rows.innovations(index, &x);
            (index, innovations, dot(&innovations, &innovations))
        })
    }
}

impl Cost<12> for WindowCost<'_> {
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        let change = self.change(y);
        let robust = self.squares(&change).fold(0.0, |sum, (_, _, square)| {
            sum + 0.5 * (SPREAD * libm::log1pf(square / SPREAD) - self.centre.usual * square)
        });
        0.5 * dot(y, y) + self.centre.share * robust
    }
}

impl LeastSquaresCost<12, 78> for WindowCost<'_> {
    fn normal_equations(&self, y: &[f32; 12], normal: &mut Packed<12, 78>, descent: &mut [f32; 12]) {
        let change = self.change(y);
        let factor = &self.centre.factor;
        let mut pull = [0.0; GYRO];
        *normal = Packed::zero();
        for k in 0..GYRO {
            normal.add(k, k, 1.0);
        }
        for (index, innovations, square) in self.squares(&change) {
            // Of the rows' own information only by how much it differs from the usual.
            let weight = self.centre.share * (weight(square) - self.centre.usual);
            for (row, innovation) in self.rows.node(index).iter().zip(innovations) {
                let [row @ .., _] = *row;
                normal.add_outer(&factor.solve_lower(&row), weight);
                for (pull, x) in pull.iter_mut().zip(row) {
                    *pull -= weight * innovation * x;
                }
            }
        }
        *descent = factor.solve_lower(&pull);
        for (descent, y) in descent.iter_mut().zip(y) {
            *descent -= y;
        }
    }
}
