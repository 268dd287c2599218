//! Matrix columns that have been eliminated, in their order, and the posterior of their unknowns.

use super::{
    column_id::{ColumnId, Columns},
    matrix::{MOST, Matrix},
};
use crate::{compensation::effect::MAX_PARAMETERS, estimator::real::Real};
use heapless::Vec;

/// Matrix columns in the order in which they were eliminated.
pub(super) struct Entered {
    columns: Vec<ColumnId, MOST>,
}

/// Mean and covariance of an effect's parameters.
pub(super) struct Posterior<T> {
    pub mean: [T; MAX_PARAMETERS],
    pub covariance: [[T; MAX_PARAMETERS]; MAX_PARAMETERS],
}

impl Entered {
    pub const fn zero() -> Self {
        Self { columns: Vec::new() }
    }

    pub fn clear(&mut self) {
        self.columns.clear();
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
