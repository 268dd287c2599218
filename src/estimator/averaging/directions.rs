//! P's posterior along the eigenvectors of its covariance: there its nine elements are independent, so that any
//! inflation of the covariance and any scale of P's prior can be weighed element by element, and averaged over.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{Gaussian, NINE};
use crate::estimator::{eigen::diagonalise, gaussian::element, real::Real};

/// Scales of P's prior, of which nobody knows how good the factory's calibration still is: log-uniform from the
/// data sheet's width down to a 256th of it, which is nothing.
pub(super) const SCALES: [f32; 9] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.031_25, 0.015_625, 0.007_812_5, 0.003_906_25];
/// Least information of the data along a direction, over the prior's: less counts as this much.
const LEAST_INFORMATION: f32 = 1e-4;
/// A direction counts as decided by the data when they leave less than half of the prior's deviation.
const DECIDED_INFORMATION: f32 = 3.0;

/// Log ratio of two weights beyond which the smaller, 2e-9 of the larger, is lost in f32: all 27 pairs of scale and
/// inflation together are 6e-8.
pub(super) const NEGLIGIBLE: f32 = 20.0;

/// P's posterior by direction. Its prior has mean 0 and variance 1 in each.
pub(super) struct Directions<T> {
    /// Unit vectors, direction k in column k.
    pub vectors: [[T; NINE]; NINE],
    /// Variances, on the diagonal.
    pub values: [[T; NINE]; NINE],
    /// Means.
    pub at: [T; NINE],
    /// Information of the data alone.
    lambda: [T; NINE],
    /// Information of the data times the mean that they alone ask for.
    pull: [T; NINE],
    /// Half of the squared pull over the information: most log evidence for a mean other than the prior's.
    most: [T; NINE],
}

impl<T: Real> Directions<T> {
    pub fn of(of: &Gaussian<T>) -> Self {
        let c = |i: usize, j: usize| if i >= j { element(&of.covariance, i, j) } else { element(&of.covariance, j, i) };
        let mut values = [[T::ZERO; NINE]; NINE];
        for i in 0..NINE {
            for j in 0..NINE {
                values[i][j] = c(i, j);
            }
        }
        let vectors = diagonalise(&mut values);
        let mut lambda = [T::ZERO; NINE];
        let mut pull = [T::ZERO; NINE];
        let mut at = [T::ZERO; NINE];
        let mut most = [T::ZERO; NINE];
        for k in 0..NINE {
            let variance = values[k][k];
            at[k] = (0..NINE).fold(T::ZERO, |sum, i| sum + vectors[i][k] * of.mean[i]);
            let information = T::ONE / variance - T::ONE;
            let least = T::of(LEAST_INFORMATION);
            lambda[k] = if information > least { information } else { least };
            pull[k] = at[k] * (lambda[k] + T::ONE);
            most[k] = T::of(0.5) * pull[k] * pull[k] / lambda[k];
        }
        Self { vectors, values, at, lambda, pull, most }
    }

    /// Number of directions that the data decide.
    pub fn decided(&self) -> u8 {
        self.lambda.iter().filter(|x| **x > T::of(DECIDED_INFORMATION)).count() as u8
    }

    /// Log evidence of an inflation of the covariance and a (squared) scale of the prior, but for a constant.
    fn likelihood(&self, inflation: T, squared_scale: T) -> T {
        let mut variances = [T::ONE; NINE + 1];
        let mut sum = T::ZERO;
        for k in 0..NINE {
            let variance = inflation + self.lambda[k] * squared_scale;
            sum += self.most[k] * (T::ONE - T::ONE / variance);
            variances[k] = variance;
        }
        // Logarithms of products of two: f32 might not hold a product of more.
        let (pairs, _) = variances.as_chunks::<2>();
        pairs.iter().fold(sum, |sum, [a, b]| sum - T::of(0.5) * (*a * *b).logarithm())
    }

    /// Averages over inflations and scales; `evidence` is the log evidence of the other sensors' widths.
    pub fn mixed(&self, inflations: &[f32], evidence: T) -> Mixed<T> {
        // The posterior already has this prior inside.
        let inside = self.likelihood(T::ONE, T::ONE);
        let mut mixed = Mixed::zero();
        for inflation in inflations.iter().copied().map(T::of) {
            for scale in SCALES.map(T::of) {
                let squared = scale * scale;
                let log = evidence + self.likelihood(inflation, squared) - inside;
                if mixed.is_negligible(log) {
                    continue;
                }
                let shrunk = inflation / squared;
                let variance = self.lambda.map(|information| inflation / (information + shrunk));
                let mut mean = self.pull;
                for (mean, information) in mean.iter_mut().zip(&self.lambda) {
                    *mean /= *information + shrunk;
                }
                mixed.add(log, &mean, &variance);
            }
        }
        mixed
    }
}

/// Weighted sums over inflations and scales, by direction.
pub(super) struct Mixed<T> {
    /// Log weight that counts as 1 in the sums: the largest so far.
    pub log: T,
    pub weight: T,
    pub mean: [T; NINE],
    /// Second moments, the lower triangle.
    pub square: [[T; NINE]; NINE],
}

impl<T: Real> Mixed<T> {
    fn zero() -> Self {
        Self { log: T::ZERO, weight: T::ZERO, mean: [T::ZERO; NINE], square: [[T::ZERO; NINE]; NINE] }
    }

    /// Returns true if a further weight, whose logarithm is given, is lost in the rounding of the sum so far.
    fn is_negligible(&self, log: T) -> bool {
        self.weight > T::ZERO && log < self.log - T::of(NEGLIGIBLE)
    }

    fn add(&mut self, log: T, mean: &[T; NINE], variance: &[T; NINE]) {
        if self.weight == T::ZERO {
            self.log = log;
        } else if log > self.log {
            let factor = (self.log - log).exponential();
            self.weight *= factor;
            self.mean.iter_mut().chain(self.square.as_flattened_mut()).for_each(|x| *x *= factor);
            self.log = log;
        }
        let weight = (log - self.log).exponential();
        self.weight += weight;
        for k in 0..NINE {
            self.mean[k] += weight * mean[k];
            for l in 0..=k {
                self.square[k][l] += weight * mean[k] * mean[l];
            }
            self.square[k][k] += weight * variance[k];
        }
    }
}
