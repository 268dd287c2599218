//! Matrix columns that have been eliminated, in their order, and the posterior of their unknowns.

use super::matrix::{MOST, Matrix};
use crate::{compensation::effect::MAX_PARAMETERS, estimator::real::Real};
use core::ops::Range;
use heapless::Vec;

/// Matrix columns in the order in which they were eliminated.
pub(super) struct Entered {
    columns: Vec<u8, MOST>,
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

    pub fn has(&self, column: usize) -> bool {
        self.columns.iter().any(|entered| usize::from(*entered) == column)
    }

    /// Returns the columns of a range that have not been eliminated yet.
    pub fn others(&self, columns: Range<usize>) -> Vec<u8, MAX_PARAMETERS> {
        columns.filter(|column| !self.has(*column)).take(MAX_PARAMETERS).map(|column| column as u8).collect()
    }

    /// Eliminates a column, unless that has been done.
    pub fn enter<T: Real>(&mut self, matrix: &mut Matrix<T>, column: usize) {
        if !self.has(column) {
            matrix.eliminate(column, self.columns.len(), |column| self.has(column));
            // There is room: each column enters once.
            let _ = self.columns.push(column as u8);
        }
    }

    /// Row of the root's inverse that belongs to a column.
    fn inverse_row<T: Real>(&self, matrix: &Matrix<T>, of: usize) -> [T; MOST] {
        let place = self.columns.iter().position(|entered| usize::from(*entered) == of).unwrap_or(0);
        let mut row = [T::ZERO; MOST];
        for (k, column) in self.columns.iter().enumerate().skip(place) {
            let unit = if k == place { T::ONE } else { T::ZERO };
            let column = matrix.column(usize::from(*column));
            let done = row.iter().zip(column).take(k).skip(place);
            let sum = done.fold(unit, |sum, (a, b)| sum - *a * *b);
            if let Some((slot, pivot)) = row.get_mut(k).zip(column.get(k)) {
                *slot = sum / *pivot;
            }
        }
        row
    }

    /// Covariance of the unknowns of two columns.
    pub fn covariance<T: Real>(&self, matrix: &Matrix<T>, a: usize, b: usize) -> T {
        dot(&self.inverse_row(matrix, a), &self.inverse_row(matrix, b))
    }

    /// Posterior of an effect whose columns have been eliminated.
    #[inline(never)]
    pub fn posterior<T: Real>(&self, matrix: &Matrix<T>, columns: Range<usize>) -> Posterior<T> {
        let mut rows = [[T::ZERO; MOST]; MAX_PARAMETERS];
        let mut mean = [T::ZERO; MAX_PARAMETERS];
        for ((row, mean), column) in rows.iter_mut().zip(&mut mean).zip(columns) {
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
