//! Errors of the magnetometer that look like another field of the earth while an axis of the body has not turned: hard
//! iron along the axis, a turn of the sensor about it and, of a tool that turns about its own axis alone, a
//! magnetometer that reads more along it and less across. What the readings seem to say of them is the noise of the
//! attitudes at which rows are made linear, and the estimate is as certain of it as it is wrong.
//!
//! Only a declared field tells of them: its norm and dip, two rows, stand in the place of all that the readings say.
//! That the field differs from it is evidence of iron, beside errors of the magnetometer's matrix of the usual size,
//! which every sensor has some of.

use super::{
    column_id::{ColumnId, Columns},
    matrix::{Matrix, at},
};
use crate::{
    algebra::cholesky::Cholesky,
    estimator::{
        columns::{ALONG, GLOBALS, HARD_IRON, MAG_MATRIX, MAG_SHAPE, MAG_TURN},
        real::Real,
        rows::{ANOTHER_FIELD, ReferenceRows},
    },
};
use heapless::Vec;

const IRON: Columns = Columns::of_group(&HARD_IRON);
const OF_MAGNETOMETER: Columns = Columns::of_magnetometer();
/// Most columns that are hidden: iron and turn of three axes, and the shape along the tool.
const MOST_HIDDEN: usize = 7;
/// Least mean square of a hidden error, in squared widths of its prior: rounding may leave none.
const LEAST_SQUARE: f32 = 1e-6;
/// Columns that are eliminated in one piece of work.
const ELIMINATED: usize = 3;

/// Axes that have not turned, and the rows of a declared field.
pub(in crate::estimator) struct Unturned<T> {
    pub axes: [bool; 3],
    /// `None` without a declared field.
    pub reference: Option<ReferenceRows<T>>,
}

impl<T: Real> Unturned<T> {
    /// No axis.
    pub const NONE: Self = Self { axes: [false; 3], reference: None };

    /// Returns true if errors of the magnetometer that the readings cannot show, of the priors' size, leave the field
    /// that is read within [`ANOTHER_FIELD`] deviations of the declared one; the others are as estimated.
    pub fn explains_the_field(&self, x: &[T; GLOBALS]) -> bool {
        let Some(rows) = &self.reference else { return false };
        let [mut aa, mut ab, mut bb] = [T::ONE, T::ZERO, T::ONE];
        for column in self.columns() {
            let [a, b] = rows.by.each_ref().map(|by| at(by, column.index()));
            (aa, ab, bb) = (aa + a * a, ab + a * b, bb + b * b);
        }
        let hidden = |column: ColumnId| self.columns().any(|hidden| hidden == column);
        let mut misfit = rows.constants;
        for (misfit, by) in misfit.iter_mut().zip(&rows.by) {
            for column in OF_MAGNETOMETER.iter().filter(|column| !hidden(*column)) {
                *misfit += at(by, column.index()) * at(x, column.index());
            }
        }
        let [a, b] = misfit;
        let square = a * a * bb - T::of(2.0) * a * b * ab + b * b * aa;
        square <= T::of(ANOTHER_FIELD * ANOTHER_FIELD) * (aa * bb - ab * ab)
    }

    /// Columns of which only a declared field tells; the hard iron last.
    fn columns(&self) -> impl Iterator<Item = ColumnId> {
        // The turns stand in the order xy xz yz: about z, y, x.
        let [x, y, z] = self.axes;
        let of = |group, axes: [bool; 3]| {
            Columns::of_group(group).iter().zip(axes).filter(|(_, axis)| *axis).map(|(column, _)| column)
        };
        let shape = Columns::of_group(&MAG_SHAPE).iter().skip(ALONG).take(usize::from(z));
        shape.chain(of(&MAG_TURN, [z, y, x])).chain(of(&HARD_IRON, [x, y, z]))
    }
}

/// The columns that are hidden in a weighing.
pub(super) struct Hidden<T> {
    unturned: Unturned<T>,
    columns: Vec<ColumnId, MOST_HIDDEN>,
    eliminated: usize,
}

impl<T: Real> Hidden<T> {
    pub const fn zero() -> Self {
        Self { unturned: Unturned::NONE, columns: Vec::new(), eliminated: 0 }
    }

    pub const fn reference(&self) -> Option<ReferenceRows<T>> {
        self.unturned.reference
    }

    /// Chooses the columns. One that was claimed when its axis had turned keeps what was learnt then.
    pub fn choose(&mut self, unturned: Unturned<T>, is_known: impl Fn(ColumnId) -> bool) {
        let before = core::mem::take(&mut self.columns);
        for column in unturned.columns().filter(|column| before.contains(column) || !is_known(*column)) {
            // There is room.
            let _ = self.columns.push(column);
        }
        self.unturned = unturned;
    }

    /// Hidden columns of the magnetometer's matrix, which own the first rows from then on.
    pub fn of_matrix(&self) -> impl Iterator<Item = ColumnId> {
        self.columns.iter().copied().take_while(|column| !IRON.has(*column))
    }

    /// Begins a weighing, or begins it anew.
    pub fn start(&mut self) {
        self.eliminated = 0;
    }

    /// Eliminates some of the columns from the matrix; once all are, their rows are those of the declared field in
    /// place of those of the readings, and the columns are as any others. `noise`: variance of the data over
    /// their stated variance, by which evidence is divided; that of the declared field does not follow from it. Returns
    /// true if something is left to do.
    pub fn hide(&mut self, matrix: &mut Matrix<T>, x: &[T; GLOBALS], noise: f32) -> bool {
        if self.eliminated == self.columns.len() {
            self.refer(matrix, x, T::of(noise));
            return false;
        }
        for _ in 0..ELIMINATED {
            let Some(column) = self.columns.get(self.eliminated) else { break };
            let before = self.columns.get(..self.eliminated).unwrap_or_default();
            let is_done = |other: usize| before.iter().any(|column| column.index() == other);
            matrix.eliminate(column.index(), self.eliminated, is_done);
            self.eliminated += 1;
        }
        true
    }

    /// Mean square of the magnetometer's matrix, in squared widths of its prior, as far as the readings show its
    /// columns; at most 1. The columns that they show say how large those are that they do not show.
    fn usual(&self, matrix: &Matrix<T>, x: &[T; GLOBALS]) -> T {
        let (mut sum, mut count) = (T::ZERO, T::ZERO);
        for column in Columns::of_group(&MAG_MATRIX).iter().filter(|column| !self.columns.contains(column)) {
            let index = column.index();
            let square = at(x, index) * at(x, index) + T::ONE / matrix.dot(index, index, self.columns.len());
            sum += if square < T::ONE { square } else { T::ONE };
            count += T::ONE;
        }
        let mean = if count > T::ZERO { sum / count } else { T::ONE };
        if mean > T::of(LEAST_SQUARE) { mean } else { T::of(LEAST_SQUARE) }
    }

    /// Replaces the rows of the columns, which are the first, by those of the declared field.
    #[inline(never)]
    fn refer(&self, matrix: &mut Matrix<T>, x: &[T; GLOBALS], noise: T) {
        let reference = self.unturned.reference.as_ref();
        let by = |row: usize, column: ColumnId| {
            reference.and_then(|rows| rows.by.get(row)).map_or(T::ZERO, |by| at(by, column.index()))
        };
        // At hidden columns of zero; the others are as they are estimated.
        let others = || OF_MAGNETOMETER.iter().filter(|column| !self.columns.contains(column));
        let constant = |row: usize| {
            let at_zero = reference.map_or(T::ZERO, |rows| at(&rows.constants, row));
            others().fold(at_zero, |sum, column| sum + by(row, column) * at(x, column.index()))
        };
        let product = |a: &dyn Fn(usize) -> T, b: &dyn Fn(usize) -> T| (a(0) * b(0) + a(1) * b(1)) * noise;
        let of = |k: usize| move |row: usize| self.columns.get(k).map_or(T::ZERO, |column| by(row, *column));
        let count = self.columns.len();
        let usual = self.usual(matrix, x);
        let variance =
            |i: usize| if self.columns.get(i).is_some_and(|column| IRON.has(*column)) { T::ONE } else { usual };
        let prior = |i: usize, j: usize| if i == j { T::ONE / variance(i) } else { T::ZERO };
        let element = |i: usize, j: usize| prior(i, j) + product(&of(i), &of(j));
        let factor = Cholesky::<T, MOST_HIDDEN>::new_or_least(count, element, T::ONE);
        let mut constants: [T; MOST_HIDDEN] = core::array::from_fn(|k| product(&of(k), &constant));
        factor.solve_lower(&mut constants);
        let size = matrix.rows;
        for column in 0..=size {
            let hidden = self.columns.iter().position(|hidden| hidden.index() == column);
            for (row, x) in matrix.column_mut(column).iter_mut().enumerate().take(count) {
                *x = match hidden {
                    Some(k) if row <= k => factor.at(k, row),
                    None if column == size => at(&constants, row),
                    _ => T::ZERO,
                };
            }
        }
    }
}
