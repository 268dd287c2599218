//! Cost that the search of a window minimises: the filter's own quadratic, with Student's t in the place of the
//! Gaussian for each node as a whole.
//!
//! It stands in the place of the paper's eq 5, the angle between gravity dead-reckoned over the window and the
//! measured specific force, which cannot see a rotation about gravity and in drilling is blind.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use core::ops::Range;

use super::{
    Estimator,
    columns::{BIAS, P},
    gyro_matrix::{GyroMatrix, unknowns},
    left_over::{COLUMNS, LeftOver, ROWS, WINDOW_NODES},
    posterior::{set_p, stepped},
    real::Real,
};
use crate::{
    algebra::{Packed, PackedCholesky, dot},
    compensation::GyroModel,
    optimizer::{Cost, LeastSquaresCost},
};
use nalgebra::Vector3;

/// Number of elements of P and b.
const GYRO: usize = COLUMNS - 1;
/// Degrees of freedom of a node's Student's t, 5, and its rows: the squared innovation at which it has half of its
/// weight.
const SPREAD: f32 = 5.0 + ROWS as f32;

/// Share of the posterior's information that the rows may take away where no node has any weight: a tenth stays.
const MOST_TAKEN: f32 = 0.9;
/// Most halvings of the share, after which it is 0.
const HALVINGS: u8 = 10;

/// Weight of a node with this squared innovation.
fn weight(square: f32) -> f32 {
    SPREAD / (SPREAD + square)
}

/// Nodes whose rows are gathered in one piece of work.
const BOUND_NODES: usize = 4;

/// Information matrix of P and b.
type GyroInformation = Packed<12, 78>;

/// Shares of the largest variance that all variances gain, one after the other, until the covariance has an inverse in
/// `f32`. Its elements are sums that round to 6e-8 of their largest part, and a scale may be known to a ten-millionth
/// of the variance of a turn that it goes with.
const ROUNDINGS: [f32; 4] = [0.0, 1e-7, 1e-6, 1e-5];

/// Inverse of the covariance, whose variances are larger by a share of the largest; `None` if it is not positive
/// definite.
fn information(covariance: &[f32; 78], share: f32) -> Option<GyroInformation> {
    let mut covariance = Packed::<12, 78>(*covariance);
    let largest = (0..GYRO).map(|i| covariance.get(i, i)).fold(0.0, |most, x| if x > most { x } else { most });
    for i in 0..GYRO {
        covariance.add(i, i, share * largest);
    }
    let covariance = covariance.cholesky()?;
    let mut information = Packed::zero();
    for i in 0..GYRO {
        let mut unit = [0.0; GYRO];
        unit[i] = 1.0;
        for (j, value) in covariance.solve(&unit).iter().enumerate().take(i + 1) {
            information.add(i, j, *value);
        }
    }
    Some(information)
}

/// Adds the information of some nodes' rows.
#[inline(never)]
fn gather<const NODES: usize>(rows: &LeftOver<NODES>, nodes: Range<usize>, into: &mut GyroInformation) {
    for index in nodes {
        let node = rows.node(index);
        let (triples, _) = node.as_chunks::<3>();
        for triple in triples {
            into.add_outers(&triple.map(|[row @ .., _]| row), 1.0);
        }
    }
}

/// Terms that make the cost one about the posterior's mean.
#[derive(Clone, Copy)]
pub(super) struct Centre {
    /// The mean, in units of the prior's widths.
    mean: [f32; GYRO],
    /// Factor of the posterior's information.
    factor: PackedCholesky<12, 78>,
    /// Share of the rows' information that the posterior holds at any inflation and any weights of the nodes.
    share: f32,
    /// Mean weight of the nodes at the posterior's mean.
    usual: f32,
}

impl Centre {
    /// Makes the terms of a posterior with this covariance, inflated by `inflation` at most; `None` if that is not
    /// positive definite.
    pub fn new<const NODES: usize>(
        rows: &LeftOver<NODES>,
        mean: &[f32; GYRO],
        covariance: &[f32; 78],
        inflation: f32,
    ) -> Option<Self> {
        let factor = ROUNDINGS.iter().find_map(|share| information(covariance, *share)?.cholesky())?;
        let weights = (0..rows.count()).fold(0.0, |sum, index| {
            let innovations = rows.innovations(index, mean);
            sum + weight(dot(&innovations, &innovations))
        });
        let usual = if rows.count() > 0 { weights / rows.count() as f32 } else { 1.0 };
        Some(Self { mean: *mean, factor, share: 1.0 / inflation, usual })
    }

    /// Bounds the search's cost, so that it has a minimum: gathers the information of some nodes' rows a call, from
    /// this one on, in scratch memory. Returns the node to go on from; `None` when the bound is set.
    #[inline(never)]
    pub fn bound_by_rows<T: Real, const NODES: usize>(
        &mut self,
        rows: &LeftOver<NODES>,
        from: usize,
        scratch: &mut [T],
    ) -> Option<usize> {
        let mut left = GyroInformation::zero();
        if from > 0 {
            left.0.iter_mut().zip(scratch.iter()).for_each(|(left, kept)| *left = kept.narrow());
        }
        let count = rows.count();
        if from >= count {
            self.bound(&left);
            return None;
        }
        let end = if from + BOUND_NODES < count { from + BOUND_NODES } else { count };
        gather(rows, from..end, &mut left);
        scratch.iter_mut().zip(&left.0).for_each(|(kept, left)| *kept = T::of(*left));
        Some(end)
    }

    /// Lowers the share until the cost has a minimum. Far from the mean no node has any weight, and what is left is the
    /// posterior's information less the rows' (`left`) at their usual weight. Along some direction the rows can hold
    /// more than the posterior, which is averaged over widths and whose P has walked since. The cost then has no lower
    /// bound, and its best point in the search box lies at the edge.
    #[inline(never)]
    fn bound(&mut self, left: &GyroInformation) {
        // In posterior deviations, where the posterior's own information is the identity.
        let mut half = [[0.0; GYRO]; GYRO];
        for (i, half) in half.iter_mut().enumerate() {
            *half = self.factor.solve_lower(&core::array::from_fn(|j| left.get(i, j)));
        }
        let mut whitened = Packed::<12, 78>::zero();
        let row = |i: usize| self.factor.solve_lower(&half.map(|half| half.get(i).copied().unwrap_or(0.0)));
        for i in 0..GYRO {
            for (j, x) in row(i).iter().enumerate().take(i + 1) {
                whitened.add(i, j, *x);
            }
        }
        for _ in 0..HALVINGS {
            let mut rest = Packed::<12, 78>::zero();
            for i in 0..GYRO {
                rest.add(i, i, MOST_TAKEN);
                for j in 0..=i {
                    rest.add(i, j, -self.share * self.usual * whitened.get(i, j));
                }
            }
            if rest.cholesky().is_some() {
                return;
            }
            self.share *= 0.5;
        }
        self.share = 0.0;
    }
}

/// Cost of a change of (P row-major, b) from the posterior's mean, in posterior deviations. It is half the squared
/// distance, which stands for the posterior with all that is older than the rows and with its shrinkage; and for each
/// node of the window, of innovation e, the change by a heavier tail: s / 2 log(1 + |e|^2 / s) - u |e|^2 / 2, with s =
/// nu + 9 and u the mean weight of the nodes at the mean, times the share of the rows' information that the posterior
/// surely has. So the search finds only what weights change that differ from node to node: if all nodes are as quiet,
/// or all as noisy, the mean is the optimum.
pub struct WindowCost<'a, const NODES: usize = WINDOW_NODES> {
    rows: &'a LeftOver<NODES>,
    centre: &'a Centre,
    /// Model at the prior's mean, and the prior's widths.
    base: GyroModel,
    sigma: [f32; GYRO],
    /// Steps of the bias that are taken out, rad/s of the compensated rate.
    steps: Vector3<f32>,
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Cost of the rows of the last 50 s of motion, which the population search minimises. `None` before a posterior
    /// that was asked for with a search, or without motion.
    #[must_use]
    pub fn window_cost(&self) -> Option<WindowCost<'_, NODES>> {
        let (centre, filter) = (self.closing.centre()?, &self.filter);
        let base = filter.model(&[T::ZERO; GYRO]);
        let mut sigma = [0.0; GYRO];
        for (slot, column) in sigma.iter_mut().zip(P.columns().chain(BIAS.columns())) {
            *slot = filter.prior.sigma.get(column).map_or(0.0, |sigma| sigma.narrow());
        }
        Some(WindowCost { rows: &filter.left_over, centre, base, sigma, steps: filter.steps() })
    }
}

impl<const NODES: usize> WindowCost<'_, NODES> {
    fn change(&self, y: &[f32; GYRO]) -> [f32; GYRO] {
        self.centre.factor.solve_upper(y)
    }

    /// The model that lies `y` from the posterior's mean, in deviations.
    #[must_use]
    pub fn model(&self, y: &[f32; GYRO]) -> GyroModel {
        let mut deviations = self.change(y);
        for ((deviation, mean), sigma) in deviations.iter_mut().zip(&self.centre.mean).zip(&self.sigma) {
            *deviation = (*deviation + mean) * sigma;
        }
        let [d @ .., x, y, z] = deviations;
        let mut model = self.base;
        set_p(&mut model, &GyroMatrix::new(&d, &self.base.p_matrix()).p);
        model.b_rad_s = (Vector3::from(self.base.b_rad_s) + Vector3::new(x, y, z)).into();
        stepped(model, &self.steps)
    }

    /// Whitened coordinates of a model: undoes [`WindowCost::model`].
    #[must_use]
    pub fn coordinates(&self, model: &GyroModel) -> [f32; GYRO] {
        let mut change = [0.0; GYRO];
        let model = stepped(*model, &-self.steps);
        let d = unknowns(&model.p_matrix(), &self.base.p_matrix());
        let b = Vector3::from(model.b_rad_s) - Vector3::from(self.base.b_rad_s);
        for (((slot, deviation), mean), sigma) in
            change.iter_mut().zip(d.iter().chain(b.iter())).zip(&self.centre.mean).zip(&self.sigma)
        {
            *slot = deviation / sigma - mean;
        }
        self.centre.factor.times_upper(&change)
    }

    /// Visits the nodes: index, innovations at `change` from the mean, and their squared sum.
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

impl<const NODES: usize> Cost<12> for WindowCost<'_, NODES> {
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        let change = self.change(y);
        let robust = self.squares(&change).fold(0.0, |sum, (_, _, square)| {
            sum + 0.5 * (SPREAD * libm::log1pf(square / SPREAD) - self.centre.usual * square)
        });
        0.5 * dot(y, y) + self.centre.share * robust
    }
}

impl<const NODES: usize> LeastSquaresCost<12, 78> for WindowCost<'_, NODES> {
    fn normal_equations(&self, y: &[f32; 12], normal: &mut Packed<12, 78>, descent: &mut [f32; 12]) {
        let change = self.change(y);
        let factor = &self.centre.factor;
        let mut pull = [0.0; GYRO];
        *normal = Packed::zero();
        for k in 0..GYRO {
            normal.add(k, k, 1.0);
        }
        for (index, innovations, square) in self.squares(&change) {
            // The posterior holds the rows' information at its usual weight, so that only the difference counts.
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

#[cfg(test)]
mod tests;
