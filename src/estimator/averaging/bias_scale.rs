//! Scale of the bias's prior, averaged over if no rest has measured the bias. The prior is as wide as the part's
//! zero-rate level, and most gyros are far better than that; so its width is averaged over, as that of P's prior is. A
//! bias that the motion hardly shows then stays the factory's, and is not noise of a zero-rate level's size.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{Averaged, GYRO, NINE, directions::SCALES};
use crate::estimator::{
    gaussian::element,
    real::{M3, Real, V3, zero3, zero33},
};

/// Information, over the prior's, that a direction keeps if the data say nothing about it.
const LEAST_INFORMATION: f32 = 1e-3;

/// Averages the bias over the scales of its prior, N(0, scale^2) in units of the prior's deviation, and moves P by its
/// regression on the bias. Changes nothing if the covariance is singular, or the data alone tell nothing of an axis.
pub fn average<T: Real>(of: &mut Averaged<T>) {
    let c = |i: usize, j: usize| element(&of.covariance, if i >= j { i } else { j }, if i >= j { j } else { i });
    let covariance = M3::from_fn(|i, j| c(NINE + i, NINE + j));
    let mean = V3::from_fn(|i, _| of.mean[NINE + i]);
    let Some(information) = covariance.try_inverse() else { return };
    // Information of the data alone: the prior is taken out again.
    let of_data = information - M3::identity() * (T::ONE - T::of(LEAST_INFORMATION));
    let Some(alone) = of_data.try_inverse().filter(|alone| (0..3).all(|i| alone[(i, i)] > T::ZERO)) else { return };
    let asked = alone * information * mean;
    let mut sum = Sum { log: T::ZERO, weight: T::ZERO, mean: zero3(), square: zero33() };
    for scale in SCALES.map(T::of) {
        let squared = scale * scale;
        let total = alone + M3::identity() * squared;
        let (determinant, Some(inverse)) = (total.determinant(), total.try_inverse()) else { return };
        if determinant <= T::ZERO {
            return;
        }
        let log = -T::of(0.5) * (determinant.logarithm() + asked.dot(&(inverse * asked)));
        sum.add(log, &(inverse * asked * squared), &(inverse * alone * squared));
    }
    let share = T::ONE / sum.weight;
    let moved = sum.mean * share - mean;
    let narrowed = sum.square * share - (sum.mean * share) * (sum.mean * share).transpose() - covariance;
    if !moved.iter().chain(narrowed.iter()).all(|x| x.is_finite()) {
        return;
    }
    // P by regression on the bias, and the bias itself.
    let by: [V3<T>; GYRO] = core::array::from_fn(|i| {
        if i < NINE {
            information * V3::from_fn(|k, _| c(NINE + k, i))
        } else {
            V3::from_fn(|k, _| unit(k + NINE == i))
        }
    });
    let mut elements = of.covariance.iter_mut();
    for (i, (mean, row)) in of.mean.iter_mut().zip(&by).enumerate() {
        *mean += row.dot(&moved);
        for (column, element) in by.iter().take(i + 1).zip(elements.by_ref()) {
            *element += row.dot(&(narrowed * column));
        }
    }
}

fn unit<T: Real>(is_one: bool) -> T {
    if is_one { T::ONE } else { T::ZERO }
}

/// Weighted sums over the scales.
struct Sum<T> {
    /// Log weight that counts as 1 in the sums: the largest so far.
    log: T,
    weight: T,
    mean: V3<T>,
    /// Second moments.
    square: M3<T>,
}

impl<T: Real> Sum<T> {
    fn add(&mut self, log: T, mean: &V3<T>, covariance: &M3<T>) {
        if self.weight == T::ZERO {
            self.log = log;
        } else if log > self.log {
            let factor = (self.log - log).exponential();
            (self.weight, self.mean, self.square) = (self.weight * factor, self.mean * factor, self.square * factor);
            self.log = log;
        }
        let weight = (log - self.log).exponential();
        self.weight += weight;
        self.mean += mean * weight;
        self.square += (covariance + mean * mean.transpose()) * weight;
    }
}

#[cfg(test)]
mod tests;
