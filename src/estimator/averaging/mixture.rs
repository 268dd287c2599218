//! The posterior of P and b as a mixture: one Gaussian at each set of widths, weighed by its evidence.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    Averaged, GYRO, Gaussian, NINE,
    directions::{Directions, Mixed, NEGLIGIBLE},
};
use crate::estimator::{
    gaussian::{element, triangle},
    real::Real,
    widths::GROUPS,
};

/// Weighted sums over the sets of widths.
#[derive(Clone, Copy)]
pub(super) struct Sum<T> {
    /// Log weight that counts as 1 in the sums: the largest so far.
    log: T,
    weight: T,
    /// Largest log weight so far: directions that are decided and unscaled variances are those of its widths.
    best: T,
    /// The average once [`Sum::finish`] has made it. Before, sums are in the place of means, second moments in that of
    /// the covariance, and sums of logarithms in that of the widths.
    pub of: Averaged<T>,
}

impl<T: Real> Sum<T> {
    pub const fn zero() -> Self {
        Self {
            log: T::ZERO,
            weight: T::ZERO,
            best: T::ZERO,
            of: Averaged {
                mean: [T::ZERO; GYRO],
                covariance: [T::ZERO; triangle(GYRO)],
                decided: 0,
                unscaled_variance: [T::ZERO; GYRO],
                widths: [T::ZERO; GROUPS],
            },
        }
    }

    /// Log of the sum of all weights.
    #[cfg(feature = "explanation")]
    pub fn log_evidence(&self) -> T {
        self.log + self.weight.logarithm()
    }

    /// Makes `log` the unit of the weights if it is larger; returns the weight of `log` in that unit.
    fn weight(&mut self, log: T) -> T {
        if self.weight == T::ZERO {
            self.log = log;
        } else if log > self.log {
            let factor = (self.log - log).exponential();
            self.weight *= factor;
            let Averaged { mean, covariance, widths, .. } = &mut self.of;
            mean.iter_mut().chain(covariance).chain(widths).for_each(|x| *x *= factor);
            self.log = log;
        }
        (log - self.log).exponential()
    }

    /// Adds P and b at one set of widths, averaged over inflations and scales. `evidence` and `widths` are logarithms;
    /// returns that of the set's weight.
    pub fn add(&mut self, of: &Gaussian<T>, inflations: &[f32], evidence: T, widths: [T; GROUPS]) -> T {
        let directions = Directions::of(of);
        let mixed = directions.mixed(inflations, evidence);
        if self.weight == T::ZERO || mixed.log > self.best {
            (self.best, self.of.decided) = (mixed.log, directions.decided());
            self.of.unscaled_variance = core::array::from_fn(|i| element(&of.covariance, i, i));
        }
        let log = mixed.log + mixed.weight.logarithm();
        if self.weight == T::ZERO || log >= self.log - T::of(NEGLIGIBLE) {
            self.add_mixed(of, &directions, &mixed, (log, widths));
        }
        log
    }

    /// Makes the average of all that was added.
    pub fn finish(&mut self) {
        let share = T::ONE / self.weight;
        let Averaged { mean, covariance, widths, .. } = &mut self.of;
        mean.iter_mut().chain(covariance.iter_mut()).for_each(|x| *x *= share);
        widths.iter_mut().for_each(|x| *x = (*x * share).exponential());
        for i in 0..GYRO {
            for j in 0..=i {
                if let Some(covariance) = covariance.get_mut(triangle(i) + j) {
                    *covariance -= mean[i] * mean[j];
                }
            }
        }
    }

    /// Inflates the covariance by the outer product of a vector, of which the first elements are those of P and b.
    pub fn inflate(&mut self, by: &[T]) {
        for (i, x) in by.iter().enumerate().take(GYRO) {
            self.of.unscaled_variance[i] += *x * *x;
            for (j, y) in by.iter().enumerate().take(i + 1) {
                if let Some(covariance) = self.of.covariance.get_mut(triangle(i) + j) {
                    *covariance += *x * *y;
                }
            }
        }
    }

    /// Adds an average over inflations and scales, brought back from the directions to P and b.
    fn add_mixed(
        &mut self,
        of: &Gaussian<T>,
        directions: &Directions<T>,
        mixed: &Mixed<T>,
        (log, widths): (T, [T; GROUPS]),
    ) {
        let Directions { vectors, values, at, .. } = directions;
        // Change of P and the bias along each direction: P's rows are the directions, the bias follows by regression.
        let mut by = [[T::ZERO; NINE]; GYRO];
        by[..NINE].copy_from_slice(vectors);
        let mut own = [T::ZERO; triangle(3)];
        for b in 0..3 {
            let row = NINE + b;
            for k in 0..NINE {
                let cross = (0..NINE).fold(T::ZERO, |sum, i| sum + element(&of.covariance, row, i) * vectors[i][k]);
                by[row][k] = cross / values[k][k];
            }
            for d in 0..=b {
                let explained = (0..NINE).fold(T::ZERO, |sum, k| sum + by[row][k] * by[NINE + d][k] * values[k][k]);
                if let Some(own) = own.get_mut(triangle(b) + d) {
                    *own = element(&of.covariance, row, NINE + d) - explained;
                }
            }
        }
        let share = T::ONE / mixed.weight;
        let mut mean = [T::ZERO; GYRO];
        for i in 0..GYRO {
            let base = if i < NINE { T::ZERO } else { of.mean[i] };
            mean[i] = (0..NINE).fold(base, |sum, k| {
                let from = if i < NINE { T::ZERO } else { at[k] };
                sum + by[i][k] * (mixed.mean[k] * share - from)
            });
        }
        // Covariance of the directions about their mean.
        let mut of_directions = [[T::ZERO; NINE]; NINE];
        for k in 0..NINE {
            for l in 0..=k {
                of_directions[k][l] = mixed.square[k][l] * share - mixed.mean[k] * mixed.mean[l] * share * share;
                of_directions[l][k] = of_directions[k][l];
            }
        }
        let weight = self.weight(log);
        self.weight += weight;
        for (sum, x) in self.of.mean.iter_mut().zip(&mean) {
            *sum += weight * *x;
        }
        for (sum, x) in self.of.widths.iter_mut().zip(&widths) {
            *sum += weight * *x;
        }
        for i in 0..GYRO {
            let mut row = [T::ZERO; NINE];
            for (l, slot) in row.iter_mut().enumerate() {
                *slot = (0..NINE).fold(T::ZERO, |sum, k| sum + by[i][k] * of_directions[k][l]);
            }
            for j in 0..=i {
                let mut x = (0..NINE).fold(mean[i] * mean[j], |sum, l| sum + row[l] * by[j][l]);
                if j >= NINE {
                    x += element(&own, i - NINE, j - NINE);
                }
                if let Some(square) = self.of.covariance.get_mut(triangle(i) + j) {
                    *square += weight * x;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
