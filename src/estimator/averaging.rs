//! What is known of P and b, averaged over what is not known of the other sensors: the widths of their errors' priors, an inflation of the
//! covariance, and the scale of P's own prior, each weighed by its evidence. The mean is what flies: where the data say nothing it stays
//! at the factory's.

#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    columns::GLOBALS,
    eigen::diagonalise,
    gaussian::{element, narrow_last, triangle},
    globals::{Globals, WIDE},
    real::Real,
    rows::WIDTH,
    widths::{COUNTS, GROUPS, HAS_LAG, LEFT_AFTER, VARIABLES, Widths, column},
};

/// Scales of P's prior, of which nobody knows how good the factory's calibration still is: log-uniform from the data sheet's width down to a
/// 256th of it, which is nothing.
const SCALES: [f32; 9] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.031_25, 0.015_625, 0.007_812_5, 0.003_906_25];
/// Information, over the prior's, below which a direction says nothing.
const LEAST_INFORMATION: f32 = 1e-4;
/// A direction counts as decided by the data when they leave less than half of the prior's deviation.
const DECIDED_INFORMATION: f32 = 3.0;

/// P and b.
const GYRO: usize = 12;
/// P.
const NINE: usize = 9;

/// Mean and covariance in units of the prior's widths, P row-major and then b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Averaged<T> {
    pub mean: [T; GYRO],
    /// Packed, lower triangle.
    pub covariance: [T; triangle(GYRO)],
    /// Directions of P that the data decide, at the most likely widths.
    pub decided: u8,
    /// Geometric mean of the widths, over the data sheets'.
    pub widths: [T; GROUPS],
}

/// What is being averaged, in pieces.
#[derive(Clone, Copy)]
pub(super) struct Averaging<T> {
    stage: usize,
    grid: Widths,
    evidence: [T; GROUPS],
    sum: Sum<T>,
}

/// All variables at the widths that the filter runs with, and what is left when a group is taken out, for its other widths: in scratch memory
/// between updates of the filter.
struct Levels<'a, T> {
    base: Slices<'a, T>,
    after: [Slices<'a, T>; GROUPS],
    work: Slices<'a, T>,
}

/// Mean and packed covariance of some variables.
struct Slices<'a, T> {
    mean: &'a mut [T],
    covariance: &'a mut [T],
}

impl<T: Real> Slices<'_, T> {
    /// Takes the variables that both have.
    fn take(&mut self, mean: &[T], covariance: &[T]) {
        copy(self.mean, mean);
        copy(self.covariance, covariance);
    }
}

/// Copies as much as there is room for.
fn copy<T: Copy>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// Cuts so many variables off the memory; `None` where it is too small.
fn cut<'a, T>(rest: &mut &'a mut [T], variables: usize) -> Option<Slices<'a, T>> {
    let (mean, next) = core::mem::take(rest).split_at_mut_checked(variables)?;
    let (covariance, next) = next.split_at_mut_checked(triangle(variables))?;
    *rest = next;
    Some(Slices { mean, covariance })
}

/// Cuts the scratch memory up; `None` where it is too small.
fn levels<T>(scratch: &mut [T]) -> Option<Levels<'_, T>> {
    let mut rest = scratch;
    let base = cut(&mut rest, VARIABLES)?;
    let [a, b, c] = LEFT_AFTER;
    let after = [cut(&mut rest, a)?, cut(&mut rest, b)?, cut(&mut rest, c)?];
    Some(Levels { base, after, work: cut(&mut rest, VARIABLES)? })
}

/// The inverse of a triangular root, column by column: packed, element (row i, column c) at (c, i) of a lower triangle.
fn invert<T: Real>(root: &[[T; WIDE]; GLOBALS], inverse: &mut [T]) {
    let mut rest = inverse;
    for c in 0..GLOBALS {
        let Some((own, next)) = core::mem::take(&mut rest).split_at_mut_checked(c + 1) else { return };
        for i in (0..=c).rev() {
            let unit = if i == c { T::ONE } else { T::ZERO };
            let Some(row) = root.get(i) else { return };
            let known = row.iter().zip(own.iter()).skip(i + 1);
            let sum = known.fold(unit, |sum, (a, x)| sum - *a * *x);
            if let (Some(slot), Some(diagonal)) = (own.get_mut(i), row.get(i)) {
                *slot = sum / *diagonal;
            }
        }
        rest = next;
    }
}

#[derive(Clone, Copy)]
struct Gaussian<T, const N: usize, const M: usize> {
    mean: [T; N],
    covariance: [T; M],
}

impl<T: Real, const N: usize, const M: usize> Gaussian<T, N, M> {
    const fn zero() -> Self {
        Self { mean: [T::ZERO; N], covariance: [T::ZERO; M] }
    }
}

/// Weighted sums.
#[derive(Clone, Copy)]
struct Sum<T> {
    /// Logarithm of the unit of the weights.
    log: T,
    weight: T,
    best: T,
    decided: u8,
    mean: [T; GYRO],
    /// Second moments.
    square: [T; triangle(GYRO)],
    widths: [T; GROUPS],
}

impl<T: Real> Sum<T> {
    const fn zero() -> Self {
        Self {
            log: T::ZERO,
            weight: T::ZERO,
            best: T::ZERO,
            decided: 0,
            mean: [T::ZERO; GYRO],
            square: [T::ZERO; triangle(GYRO)],
            widths: [T::ZERO; GROUPS],
        }
    }

    /// Brings the unit of the weights up to `log`, and gives a weight of `log` in it.
    fn weight(&mut self, log: T) -> T {
        if self.weight == T::ZERO {
            self.log = log;
        } else if log > self.log {
            let factor = (self.log - log).exponential();
            self.weight *= factor;
            let sums = self.mean.iter_mut().chain(&mut self.square).chain(&mut self.widths);
            sums.for_each(|x| *x *= factor);
            self.log = log;
        }
        (log - self.log).exponential()
    }
}

impl<T: Real> Averaging<T> {
    pub const fn zero() -> Self {
        Self { stage: 0, grid: Widths::UNSET, evidence: [T::ZERO; GROUPS], sum: Sum::zero() }
    }

    /// Begins: `scratch` takes mean and covariance, and for a moment the inverse of the root.
    pub fn start(&mut self, globals: &Globals<T>, widths: &Widths, scratch: &mut [[T; WIDTH]]) {
        self.stage = 0;
        self.grid = *widths;
        self.sum = Sum::zero();
        let scratch = scratch.as_flattened_mut();
        // At the end, where it is in nobody's way; column c has c + 1 elements.
        let Some(place) = scratch.len().checked_sub(triangle(GLOBALS)) else { return };
        let (front, inverse) = scratch.split_at_mut(place);
        invert(&globals.root, inverse);
        let mut rest = front;
        let Some(base) = cut(&mut rest, VARIABLES) else { return };
        let mut elements = base.covariance.iter_mut();
        for (i, mean) in base.mean.iter_mut().enumerate() {
            let a = column(i);
            *mean = globals.x.get(a).copied().unwrap_or(T::ZERO);
            for (j, covariance) in (0..=i).zip(&mut elements) {
                let b = column(j);
                // Column c of the inverse reaches down to row c.
                let from = if a > b { a } else { b };
                *covariance =
                    (from..GLOBALS).fold(T::ZERO, |sum, c| sum + element(inverse, c, a) * element(inverse, c, b));
            }
        }
    }

    /// One width of each group; `false` when all are done. `scratch` must be left alone from one to the next.
    pub fn step(&mut self, scratch: &mut [[T; WIDTH]]) -> bool {
        let [mags, irons, accels] = self.grid.count;
        let quotient = |stage: usize, by: usize| stage.checked_div(by).unwrap_or(0);
        let remainder = |stage: usize, by: usize| stage.checked_rem(by).unwrap_or(0);
        if self.stage >= mags * irons * accels {
            return false;
        }
        let Some(mut levels) = levels(scratch.as_flattened_mut()) else { return false };
        let chosen = [
            quotient(self.stage, irons * accels),
            remainder(quotient(self.stage, accels), irons),
            remainder(self.stage, accels),
        ];
        // The first group whose width is another one than before, and all after it.
        let from = if chosen[2] > 0 {
            2
        } else if chosen[1] > 0 {
            1
        } else {
            0
        };
        let part = |group: usize| {
            let widths = self.grid.parts.get(group).zip(chosen.get(group));
            widths.and_then(|(widths, index)| widths.get(*index)).copied().unwrap_or(1.0)
        };
        let [after_mag, after_iron, after_accel] = &mut levels.after;
        let work = &mut levels.work;
        let with_lags = self.grid.with_lags;
        let [of_mag, of_iron, of_accel] = &mut self.evidence;
        if from == 0 {
            work.take(levels.base.mean, levels.base.covariance);
            *of_mag = narrowed(work, VARIABLES, 0, T::of(part(0)), with_lags);
            after_mag.take(work.mean, work.covariance);
        }
        if from <= 1 {
            work.take(after_mag.mean, after_mag.covariance);
            *of_iron = narrowed(work, LEFT_AFTER[0], 1, T::of(part(1)), with_lags);
            after_iron.take(work.mean, work.covariance);
        }
        work.take(after_iron.mean, after_iron.covariance);
        *of_accel = narrowed(work, LEFT_AFTER[1], 2, T::of(part(2)), with_lags);
        after_accel.take(work.mean, work.covariance);
        let mut widths = [T::ZERO; GROUPS];
        for (group, (width, sheet)) in widths.iter_mut().zip(self.grid.sheet).enumerate() {
            *width = T::of(part(group) / sheet).logarithm();
        }
        let evidence = self.evidence.iter().fold(T::ZERO, |sum, x| sum + *x);
        let mut of = Gaussian::<T, GYRO, { triangle(GYRO) }>::zero();
        copy(&mut of.mean, after_accel.mean);
        copy(&mut of.covariance, after_accel.covariance);
        let inflations = self.grid.inflations.get(..self.grid.inflation_count).unwrap_or_default();
        self.sum.add(&of, inflations, evidence, widths);
        self.stage += 1;
        true
    }

    /// The average.
    pub fn result(&self) -> Averaged<T> {
        let share = T::ONE / self.sum.weight;
        let mean = self.sum.mean.map(|x| x * share);
        let mut covariance = self.sum.square.map(|x| x * share);
        for i in 0..GYRO {
            for j in 0..=i {
                if let Some(covariance) = covariance.get_mut(triangle(i) + j) {
                    *covariance -= mean[i] * mean[j];
                }
            }
        }
        Averaged {
            mean,
            covariance,
            decided: self.sum.decided,
            widths: self.sum.widths.map(|x| (x * share).exponential()),
        }
    }
}

/// Narrows the priors of a group, the last of the variables, and takes these out of the mean and covariance that stay; the logarithm of the
/// evidence.
fn narrowed<T: Real>(all: &mut Slices<T>, variables: usize, group: usize, width: T, with_lags: bool) -> T {
    let mut evidence = T::ZERO;
    let (Some(count), Some(has_lag)) = (COUNTS.get(group), HAS_LAG.get(group)) else { return evidence };
    for n in (variables - count + 1..=variables).rev() {
        let width = if n == variables && *has_lag && !with_lags { T::ONE } else { width };
        if let (Some(mean), Some(covariance)) = (all.mean.get_mut(..n), all.covariance.get_mut(..triangle(n))) {
            evidence += narrow_last(mean, covariance, width);
        }
    }
    evidence
}

impl<T: Real> Sum<T> {
    /// Adds one set of widths: the mean over inflations and scales of what bias and P then are.
    fn add<const M: usize>(&mut self, of: &Gaussian<T, GYRO, M>, inflations: &[f32], evidence: T, widths: [T; GROUPS]) {
        let c = |i: usize, j: usize| if i >= j { element(&of.covariance, i, j) } else { element(&of.covariance, j, i) };
        let mut values = [[T::ZERO; NINE]; NINE];
        for i in 0..NINE {
            for j in 0..NINE {
                values[i][j] = c(i, j);
            }
        }
        let vectors = diagonalise(&mut values);
        // In these directions P's posterior has the mean `at` and the variance `variance`, its prior 0 and 1, so the data have the information
        // `lambda` and pull by `pull`.
        let mut lambda = [T::ZERO; NINE];
        let mut pull = [T::ZERO; NINE];
        let mut at = [T::ZERO; NINE];
        for k in 0..NINE {
            let variance = values[k][k];
            at[k] = (0..NINE).fold(T::ZERO, |sum, i| sum + vectors[i][k] * of.mean[i]);
            let information = T::ONE / variance - T::ONE;
            let least = T::of(LEAST_INFORMATION);
            lambda[k] = if information > least { information } else { least };
            pull[k] = at[k] * (lambda[k] + T::ONE);
        }
        let decided = lambda.iter().filter(|x| **x > T::of(DECIDED_INFORMATION)).count() as u8;
        let half = T::of(0.5);
        let likelihood = |inflation: T, squared_scale: T| {
            (0..NINE).fold(T::ZERO, |sum, k| {
                let spread = inflation + lambda[k] * squared_scale;
                sum - half * spread.logarithm() + half * pull[k] * pull[k] / lambda[k] * (T::ONE - T::ONE / spread)
            })
        };
        // That of the prior that is inside.
        let inside = likelihood(T::ONE, T::ONE);
        let mut mixed = Mixed::zero();
        for inflation in inflations.iter().copied().map(T::of) {
            for scale in SCALES.map(T::of) {
                let squared = scale * scale;
                let log = evidence + likelihood(inflation, squared) - inside;
                let shrunk = inflation / squared;
                let variance = lambda.map(|information| inflation / (information + shrunk));
                let mut mean = pull;
                for (mean, information) in mean.iter_mut().zip(&lambda) {
                    *mean /= *information + shrunk;
                }
                mixed.add(log, &mean, &variance);
            }
        }
        if self.weight == T::ZERO || mixed.log > self.best {
            (self.best, self.decided) = (mixed.log, decided);
        }
        self.add_mixed(of, &vectors, &values, &at, &mixed, widths);
    }

    /// Adds it, brought back from the directions.
    fn add_mixed<const M: usize>(
        &mut self,
        of: &Gaussian<T, GYRO, M>,
        vectors: &[[T; NINE]; NINE],
        values: &[[T; NINE]; NINE],
        at: &[T; NINE],
        mixed: &Mixed<T>,
        widths: [T; GROUPS],
    ) {
        // Of bias and P by direction: P itself, and the bias that goes with it.
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
        let mut spread = [[T::ZERO; NINE]; NINE];
        for k in 0..NINE {
            for l in 0..NINE {
                spread[k][l] = mixed.square[k][l] * share - mixed.mean[k] * mixed.mean[l] * share * share;
            }
        }
        let weight = self.weight(mixed.log + mixed.weight.logarithm());
        self.weight += weight;
        for (sum, x) in self.mean.iter_mut().zip(&mean) {
            *sum += weight * *x;
        }
        for (sum, x) in self.widths.iter_mut().zip(&widths) {
            *sum += weight * *x;
        }
        for i in 0..GYRO {
            let mut row = [T::ZERO; NINE];
            for (l, slot) in row.iter_mut().enumerate() {
                *slot = (0..NINE).fold(T::ZERO, |sum, k| sum + by[i][k] * spread[k][l]);
            }
            for j in 0..=i {
                let mut x = (0..NINE).fold(mean[i] * mean[j], |sum, l| sum + row[l] * by[j][l]);
                if j >= NINE {
                    x += element(&own, i - NINE, j - NINE);
                }
                if let Some(square) = self.square.get_mut(triangle(i) + j) {
                    *square += weight * x;
                }
            }
        }
    }
}

/// The mean over inflations and scales, in directions.
struct Mixed<T> {
    log: T,
    weight: T,
    mean: [T; NINE],
    square: [[T; NINE]; NINE],
}

impl<T: Real> Mixed<T> {
    fn zero() -> Self {
        Self { log: T::ZERO, weight: T::ZERO, mean: [T::ZERO; NINE], square: [[T::ZERO; NINE]; NINE] }
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
            for l in 0..NINE {
                self.square[k][l] += weight * mean[k] * mean[l];
            }
            self.square[k][k] += weight * variance[k];
        }
    }
}
