//! All that the data say of nuisances and effects whatever the gyro's parameters are: the root in another order,
//! column by column.

#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{Candidates, EFFECTS};
use crate::{
    compensation::effect::MAX_PARAMETERS,
    estimator::{
        cholesky::Cholesky,
        columns::{BIAS, GLOBALS, NUISANCES},
        globals::Globals,
        real::Real,
    },
};
use core::ops::Range;

/// Most rows of the matrix.
pub(super) const MOST: usize = NUISANCES + EFFECTS;
/// Value of a factor of which rounding leaves nothing.
pub(super) const LEAST_FACTOR: f32 = 1e-10;
/// P and b.
const GYRO: usize = GLOBALS - NUISANCES;

/// The matrix, column by column, in two pieces of scratch memory.
pub(super) struct Matrix<'a, T> {
    pub rows: usize,
    in_first: usize,
    first: &'a mut [T],
    second: &'a mut [T],
}

impl<'a, T: Real> Matrix<'a, T> {
    pub fn new(rows: usize, first: &'a mut [T], second: &'a mut [T]) -> Self {
        Self { rows, in_first: first.len().checked_div(rows).unwrap_or(0), first, second }
    }

    pub fn column(&self, column: usize) -> &[T] {
        match column.checked_sub(self.in_first) {
            None => self.first.get(column * self.rows..(column + 1) * self.rows),
            Some(column) => self.second.get(column * self.rows..(column + 1) * self.rows),
        }
        .unwrap_or_default()
    }

    fn column_mut(&mut self, column: usize) -> &mut [T] {
        match column.checked_sub(self.in_first) {
            None => self.first.get_mut(column * self.rows..(column + 1) * self.rows),
            Some(column) => self.second.get_mut(column * self.rows..(column + 1) * self.rows),
        }
        .unwrap_or_default()
    }

    pub fn dot(&self, a: usize, b: usize, from: usize) -> T {
        self.column(a).iter().zip(self.column(b)).skip(from).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
    }

    /// Eliminates a column from the rows from `from` on.
    pub fn eliminate(&mut self, column: usize, from: usize) {
        let mut v = [T::ZERO; MOST];
        for (v, x) in v.iter_mut().zip(self.column(column)) {
            *v = *x;
        }
        let square = v.iter().skip(from).fold(T::ZERO, |sum, x| sum + *x * *x);
        let Some(x) = v.get_mut(from) else { return };
        let norm = square.root();
        if norm <= T::ZERO {
            return;
        }
        let alpha = if *x > T::ZERO { -norm } else { norm };
        *x -= alpha;
        let beta = T::ONE / (alpha * *x);
        for c in 0..=self.rows {
            let column = self.column_mut(c);
            let dot = column.iter().zip(&v).skip(from).fold(T::ZERO, |sum, (a, v)| sum + *a * *v);
            let factor = beta * dot;
            for (a, v) in column.iter_mut().zip(&v).skip(from) {
                *a += factor * *v;
            }
        }
    }
}

/// Density of a posterior at zero against that of its prior, N(0, 1) (Savage and Dickey): x^T C^-1 x / 2 + log det C
/// / 2.
pub(super) fn savage_dickey<T: Real>(
    x: &[T; MAX_PARAMETERS],
    covariance: &[[T; MAX_PARAMETERS]; MAX_PARAMETERS],
    n: usize,
) -> T {
    let factor = Cholesky::<T, MAX_PARAMETERS>::new_or_least(
        n,
        |i, j| covariance.get(i).map_or(T::ZERO, |row| at(row, j)),
        T::of(LEAST_FACTOR),
    );
    let mut solved = *x;
    factor.solve_lower(&mut solved);
    half_square(&solved, n) + factor.half_log_determinant()
}

fn half_square<T: Real>(x: &[T; MAX_PARAMETERS], n: usize) -> T {
    x.iter().take(n).fold(T::ZERO, |sum, x| sum + *x * *x) * T::of(0.5)
}

pub(super) fn at_most(n: usize, most: usize) -> usize {
    if n < most { n } else { most }
}

/// An element; 0 beyond the last.
pub(super) fn at<T: Real>(all: &[T], index: usize) -> T {
    all.get(index).copied().unwrap_or(T::ZERO)
}

/// An effect beside those that are in: the factor of its information, and the solution of its lower triangle.
pub(super) struct Beside<T> {
    factor: Cholesky<T, MAX_PARAMETERS>,
    solved: [T; MAX_PARAMETERS],
    count: usize,
}

impl<T: Real> Beside<T> {
    /// An effect of these columns, where `done` rows are of those that are in. `None` where the data say nothing of
    /// one of them.
    #[inline(never)]
    pub fn new(matrix: &Matrix<T>, columns: &[u8], done: usize) -> Option<Self> {
        let of = |i: usize| columns.get(i).map_or(0, |column| usize::from(*column));
        let count = at_most(columns.len(), MAX_PARAMETERS);
        let factor = Cholesky::new(count, |i, j| matrix.dot(of(i), of(j), done))?;
        let mut solved = [T::ZERO; MAX_PARAMETERS];
        for (i, solved) in solved.iter_mut().enumerate().take(count) {
            *solved = matrix.dot(of(i), matrix.rows, done);
        }
        factor.solve_lower(&mut solved);
        Some(Self { factor, solved, count })
    }

    /// Log Bayes factor; `None` where its only parameter has not the sign that it must have.
    pub fn evidence(&self, sign: Option<T>) -> Option<f32> {
        // The optimum of one parameter is minus its solved value.
        let is_possible = sign.is_none_or(|sign| -self.solved[0] * sign >= T::ZERO);
        let evidence = half_square(&self.solved, self.count) - self.factor.half_log_determinant();
        is_possible.then(|| evidence.narrow())
    }

    /// Mean and variance of each parameter.
    pub fn estimate(&self) -> impl Iterator<Item = (f32, f32)> {
        let mut mean = self.solved;
        self.factor.solve_upper(&mut mean);
        let both = move |i: usize| (-at(&mean, i).narrow(), self.factor.inverse_diagonal(i).narrow());
        (0..self.count).map(both)
    }
}

/// Fills columns of the matrix: nuisances, effects, constants.
pub(super) fn load<T: Real, const E: usize>(
    matrix: &mut Matrix<T>,
    columns: Range<usize>,
    globals: &Globals<T>,
    candidates: &Candidates<T, E>,
) {
    // Reflections that eliminate the gyro's columns.
    let mut reflections = [[T::ZERO; GLOBALS]; GYRO];
    let mut betas = [T::ZERO; GYRO];
    let apply = |reflections: &[[T; GLOBALS]; GYRO], betas: &[T; GYRO], count: usize, column: &mut [T; GLOBALS]| {
        for (v, beta) in reflections.iter().zip(betas).take(count) {
            let dot = v.iter().zip(column.iter()).fold(T::ZERO, |sum, (v, x)| sum + *v * *x);
            for (x, v) in column.iter_mut().zip(v) {
                *x += *beta * dot * *v;
            }
        }
    };
    for g in 0..GYRO {
        let mut column: [T; GLOBALS] = core::array::from_fn(|i| globals.root[i][BIAS.from + g]);
        apply(&reflections, &betas, g, &mut column);
        column.iter_mut().take(g).for_each(|x| *x = T::ZERO);
        let norm = column.iter().fold(T::ZERO, |sum, x| sum + *x * *x).root();
        let alpha = if column[g] > T::ZERO { -norm } else { norm };
        column[g] -= alpha;
        betas[g] = T::ONE / (alpha * column[g]);
        reflections[g] = column;
    }
    let count = candidates.used();
    for c in columns {
        let mut column = [T::ZERO; GLOBALS];
        for (i, x) in column.iter_mut().enumerate() {
            *x = match c.checked_sub(NUISANCES) {
                None => globals.root[i][c],
                Some(e) if e < count => candidates.globals.get(i).map_or(T::ZERO, |row| at(row, e)),
                // Where all nuisances and effects are zero.
                _ => {
                    let of_nuisances = (0..NUISANCES).fold(T::ZERO, |sum, n| sum - globals.root[i][n] * globals.x[n]);
                    (0..count).fold(of_nuisances, |sum, e| sum - candidates.globals[i][e] * candidates.x[e])
                }
            };
        }
        apply(&reflections, &betas, GYRO, &mut column);
        let to = matrix.column_mut(c);
        for (to, x) in to.iter_mut().zip(column.iter().skip(GYRO)) {
            *to = *x;
        }
        for (row, to) in to.iter_mut().skip(NUISANCES).enumerate().take(count) {
            *to = match c.checked_sub(NUISANCES) {
                None => T::ZERO,
                Some(e) if e < count => candidates.root[row][e],
                _ => {
                    (0..count).fold(candidates.constants[row], |sum, e| sum - candidates.root[row][e] * candidates.x[e])
                }
            };
        }
    }
}
