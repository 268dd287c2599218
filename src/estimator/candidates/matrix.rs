//! Matrix of all that the data say of nuisances and effects, whatever the gyro's parameters are: the root in another
//! order, column by column.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{Candidates, EFFECTS, column_id::ColumnId};
use crate::{
    algebra::cholesky::Cholesky,
    compensation::effect::MAX_PARAMETERS,
    estimator::{
        columns::{BIAS, GLOBALS, NUISANCES},
        globals::Globals,
        real::Real,
        square_root::Reflection,
        unrolled::{add_times, dot},
    },
};
use core::ops::Range;

/// Most rows of the matrix.
pub(super) const MOST: usize = NUISANCES + EFFECTS;
/// Pivot of a Cholesky factor in place of one that rounding made zero or negative.
pub(super) const LEAST_FACTOR: f32 = 1e-10;
/// Number of elements of P and b.
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

    pub fn column_mut(&mut self, column: usize) -> &mut [T] {
        match column.checked_sub(self.in_first) {
            None => self.first.get_mut(column * self.rows..(column + 1) * self.rows),
            Some(column) => self.second.get_mut(column * self.rows..(column + 1) * self.rows),
        }
        .unwrap_or_default()
    }

    pub fn dot(&self, a: usize, b: usize, from: usize) -> T {
        let of = |column: usize| self.column(column).get(from..).unwrap_or_default();
        dot(of(a), of(b))
    }

    /// Eliminates a column from row `from` downwards; the rows above stay as they are.
    pub fn eliminate(&mut self, column: usize, from: usize, is_done: impl Fn(usize) -> bool) {
        let mut v = [T::ZERO; MOST];
        for (v, x) in v.iter_mut().zip(self.column(column)) {
            *v = *x;
        }
        // Rows below the last element belong to later effects and are zero in this column.
        let end = v.iter().rposition(|x| *x != T::ZERO).map_or(0, |last| last + 1);
        let Some(v) = v.get_mut(from..end) else { return };
        let norm = dot(v, v).root();
        let Some(x) = v.first_mut().filter(|_| norm > T::ZERO) else { return };
        let alpha = if *x > T::ZERO { -norm } else { norm };
        *x -= alpha;
        let beta = T::ONE / (alpha * *x);
        for c in (0..=self.rows).filter(|c| !is_done(*c)) {
            let column = self.column_mut(c).get_mut(from..end).unwrap_or_default();
            let factor = beta * dot(column, v);
            add_times(column, factor, v);
        }
    }
}

/// Density of a posterior at zero against that of its prior, N(0, 1) (Savage and Dickey): x^T C^-1 x / 2 + log det C
/// / 2.
#[inline(never)]
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

/// An effect beside the eliminated ones: Cholesky factor of its information, and solution of its lower triangle.
pub(super) struct Beside<T> {
    factor: Cholesky<T, MAX_PARAMETERS>,
    solved: [T; MAX_PARAMETERS],
    count: usize,
}

impl<T: Real> Beside<T> {
    /// Weighs an effect of these columns; the eliminated columns own the first `done` rows. `None` if the data say
    /// nothing of one of its columns.
    #[inline(never)]
    pub fn new(matrix: &Matrix<T>, columns: &[ColumnId], done: usize) -> Option<Self> {
        let of = |i: usize| columns.get(i).map_or(0, |column| column.index());
        let count = at_most(columns.len(), MAX_PARAMETERS);
        let factor = Cholesky::new(count, |i, j| matrix.dot(of(i), of(j), done))?;
        let mut solved = [T::ZERO; MAX_PARAMETERS];
        for (i, solved) in solved.iter_mut().enumerate().take(count) {
            *solved = matrix.dot(of(i), matrix.rows, done);
        }
        factor.solve_lower(&mut solved);
        Some(Self { factor, solved, count })
    }

    /// Log Bayes factor; `None` if its only parameter has a sign that is impossible for it.
    pub fn evidence(&self, sign: Option<T>) -> Option<f32> {
        // The optimum of one parameter is minus its solved value.
        let is_possible = sign.is_none_or(|sign| -self.solved[0] * sign >= T::ZERO);
        let evidence = half_square(&self.solved, self.count) - self.factor.half_log_determinant();
        is_possible.then(|| evidence.narrow())
    }

    /// Variance of parameter `k`.
    pub fn variance(&self, k: usize) -> f32 {
        self.factor.inverse_diagonal(k).narrow()
    }

    /// Mean and variance of each parameter.
    pub fn estimate(&self) -> impl Iterator<Item = (f32, f32)> {
        let mut mean = self.solved;
        self.factor.solve_upper(&mut mean);
        let both = move |i: usize| (-at(&mean, i).narrow(), self.variance(i));
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
    // Reflections that take the gyro's columns of the nuisances' rows into its own rows, which are triangular.
    let mut reflections = [Reflection::<T, NUISANCES>::NOTHING; GYRO];
    for g in 0..GYRO {
        let mut column: [T; NUISANCES] = core::array::from_fn(|i| globals.root[i][BIAS.from + g]);
        let (before, own) = reflections.split_at_mut(g);
        for (reflection, row) in before.iter().zip(globals.root.iter().skip(NUISANCES)) {
            let mut pivot = row[BIAS.from + g];
            reflection.turn_one(&mut pivot, &mut column);
        }
        let mut pivot = globals.root[NUISANCES + g][BIAS.from + g];
        own[0] = Reflection::new(&mut pivot, &column);
    }
    let count = candidates.places.used();
    for c in columns {
        let mut column = [T::ZERO; GLOBALS];
        for (i, x) in column.iter_mut().enumerate() {
            *x = match c.checked_sub(NUISANCES) {
                None => globals.root[i][c],
                Some(e) if e < count => candidates.root.globals.get(i).map_or(T::ZERO, |row| at(row, e)),
                // Constants, at nuisances and effects of zero.
                _ => {
                    let of_nuisances = (0..NUISANCES).fold(T::ZERO, |sum, n| sum - globals.root[i][n] * globals.x[n]);
                    (0..count).fold(of_nuisances, |sum, e| sum - candidates.root.globals[i][e] * candidates.root.x[e])
                }
            };
        }
        let (column, of_gyro) = column.split_at_mut(NUISANCES);
        let Some(column) = column.first_chunk_mut::<NUISANCES>() else { return };
        for (reflection, pivot) in reflections.iter().zip(of_gyro) {
            reflection.turn_one(pivot, column);
        }
        let to = matrix.column_mut(c);
        for (to, x) in to.iter_mut().zip(column) {
            *to = *x;
        }
        for (row, to) in to.iter_mut().skip(NUISANCES).enumerate().take(count) {
            *to = match c.checked_sub(NUISANCES) {
                None => T::ZERO,
                Some(e) if e < count => candidates.root.own[row][e],
                _ => (0..count).fold(candidates.root.constants[row], |sum, e| {
                    sum - candidates.root.own[row][e] * candidates.root.x[e]
                }),
            };
        }
    }
}
