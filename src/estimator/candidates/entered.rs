//! Matrix columns that have been eliminated, in their order, and the posterior of their unknowns.

use super::{
    column_id::{ColumnId, Columns},
    matrix::{MOST, Matrix, at, savage_dickey},
};
use crate::{compensation::effect::MAX_PARAMETERS, estimator::real::Real};
use heapless::Vec;

/// Matrix columns in the order in which they were eliminated.
pub(super) struct Entered {
    columns: Vec<ColumnId, MOST>,
    /// Number of columns, the first, that were eliminated before any candidate was weighed.
    given: usize,
}

/// Mean and covariance of an effect's parameters.
pub(super) struct Posterior<T> {
    pub mean: [T; MAX_PARAMETERS],
    pub covariance: [[T; MAX_PARAMETERS]; MAX_PARAMETERS],
}

impl<T: Real> Posterior<T> {
    /// Returns this posterior with each deviation times its factor.
    pub fn scaled(&self, by: &[T; MAX_PARAMETERS]) -> Self {
        let Self { mean, mut covariance } = *self;
        for (row, a) in covariance.iter_mut().zip(by) {
            row.iter_mut().zip(by).for_each(|(x, b)| *x *= *a * *b);
        }
        Self { mean, covariance }
    }
}

impl Entered {
    pub const fn zero() -> Self {
        Self { columns: Vec::new(), given: 0 }
    }

    pub fn clear(&mut self) {
        self.columns.clear();
        self.given = 0;
    }

    /// Begins with columns that are eliminated already, in this order. They are no evidence of anything.
    pub fn begin_with(&mut self, columns: impl Iterator<Item = ColumnId>) {
        self.columns.clear();
        for column in columns {
            // There is room: each column enters once.
            let _ = self.columns.push(column);
        }
        self.given = self.columns.len();
    }

    /// Evidence that the columns of a posterior are not zero, but for those that it began with, see [`savage_dickey`].
    pub fn evidence<T: Real>(&self, columns: Columns, posterior: &Posterior<T>) -> T {
        let given = self.columns.get(..self.given).unwrap_or_default();
        let mut places = Vec::<usize, MAX_PARAMETERS>::new();
        for (place, _) in columns.iter().enumerate().filter(|(_, column)| !given.contains(column)) {
            // There is room.
            let _ = places.push(place);
        }
        let mut mean = [T::ZERO; MAX_PARAMETERS];
        let mut covariance = [[T::ZERO; MAX_PARAMETERS]; MAX_PARAMETERS];
        for ((mean, row), place) in mean.iter_mut().zip(&mut covariance).zip(&places) {
            *mean = at(&posterior.mean, *place);
            for (element, other) in row.iter_mut().zip(&places) {
                *element = posterior.covariance.get(*place).map_or(T::ZERO, |row| at(row, *other));
            }
        }
        savage_dickey(&mean, &covariance, places.len())
    }

    /// Returns the number of columns.
    pub fn count(&self) -> usize {
        self.columns.len()
    }

    pub fn has(&self, column: ColumnId) -> bool {
        self.columns.contains(&column)
    }

    /// Returns those of the columns that have not been eliminated yet.
    pub fn others(&self, columns: Columns) -> Vec<ColumnId, MAX_PARAMETERS> {
        columns.iter().filter(|column| !self.has(*column)).take(MAX_PARAMETERS).collect()
    }

    /// Eliminates a column, unless that has been done.
    pub fn enter<T: Real>(&mut self, matrix: &mut Matrix<T>, column: ColumnId) {
        if !self.has(column) {
            let is_done = |other: usize| self.columns.iter().any(|entered| entered.index() == other);
            matrix.eliminate(column.index(), self.columns.len(), is_done);
            // There is room: each column enters once.
            let _ = self.columns.push(column);
        }
    }

    /// Row of the root's inverse that belongs to a column.
    fn inverse_row<T: Real>(&self, matrix: &Matrix<T>, of: ColumnId) -> [T; MOST] {
        let place = self.columns.iter().position(|entered| *entered == of).unwrap_or(0);
        let mut row = [T::ZERO; MOST];
        for (k, column) in self.columns.iter().enumerate().skip(place) {
            let unit = if k == place { T::ONE } else { T::ZERO };
            let column = matrix.column(column.index());
            let done = row.iter().zip(column).take(k).skip(place);
            let sum = done.fold(unit, |sum, (a, b)| sum - *a * *b);
            if let Some((slot, pivot)) = row.get_mut(k).zip(column.get(k)) {
                *slot = sum / *pivot;
            }
        }
        row
    }

    /// Covariance of the unknowns of two columns.
    pub fn covariance<T: Real>(&self, matrix: &Matrix<T>, a: ColumnId, b: ColumnId) -> T {
        dot(&self.inverse_row(matrix, a), &self.inverse_row(matrix, b))
    }

    /// Posterior of an effect whose columns have been eliminated.
    #[inline(never)]
    pub fn posterior<T: Real>(&self, matrix: &Matrix<T>, columns: Columns) -> Posterior<T> {
        let mut rows = [[T::ZERO; MOST]; MAX_PARAMETERS];
        let mut mean = [T::ZERO; MAX_PARAMETERS];
        for ((row, mean), column) in rows.iter_mut().zip(&mut mean).zip(columns.iter()) {
            *row = self.inverse_row(matrix, column);
            *mean = -dot(row, matrix.column(matrix.rows));
        }
        let mut covariance = [[T::ZERO; MAX_PARAMETERS]; MAX_PARAMETERS];
        for (of, row) in covariance.iter_mut().zip(&rows) {
            for (element, other) in of.iter_mut().zip(&rows) {
                *element = dot(row, other);
            }
        }
        Posterior { mean, covariance }
    }
}

fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests;
