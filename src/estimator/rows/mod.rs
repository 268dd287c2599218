//! Rows of a node, one kind a file. A row reads: coefficients times changes of the unknowns, plus a constant, is
//! noise of variance 1.

mod bounds;
mod field;
mod path;
mod reference;
mod rest;
mod rotation;

pub(super) use bounds::bounds;
pub(super) use field::{FieldReading, field, field_walk};
pub(super) use path::{PathNoise, path};
pub(super) use reference::{ANOTHER_FIELD, Declared, ReferenceRows, dip_sine, reference, reference_rows};
pub(super) use rest::{REST_WEIGHT, rest};
pub(super) use rotation::rotation;

use super::{
    columns::{GLOBALS, NODE},
    real::{M3, Real, V3},
};

/// First column of the old node's states, of the new node's, of the globals; the constant.
pub(super) const OLD: usize = 0;
pub(super) const NEW: usize = NODE;
pub(super) const GLOBAL: usize = 2 * NODE;
pub(super) const CONSTANT: usize = GLOBAL + GLOBALS;
/// Number of columns.
pub(super) const WIDTH: usize = CONSTANT + 1;
/// Rows of a node: rotation, field, its walk, velocity, position, two bounds, rest or declared field; three each.
pub(super) const ROWS: usize = 24;
/// Rows of an update, 36, and ten more that the evidence of the effects needs.
pub(super) const SCRATCH: usize = NODE + ROWS + 10;

/// Combines each axis' elements of nine vectors into columns.
fn by_axis<T: Real, const K: usize>(vectors: &[V3<T>; 9], columns: impl Fn(&[T; 9]) -> [T; K]) -> [[T; K]; 3] {
    [vectors.map(|v| v.x), vectors.map(|v| v.y), vectors.map(|v| v.z)].map(|elements| columns(&elements))
}

/// Three rows, one per axis.
pub(super) struct Block<'a, T> {
    pub rows: &'a mut [[T; WIDTH]],
    /// One over the deviation of the rows' noise.
    pub weight: T,
    /// Prior widths of the globals, whose columns are in units of these.
    pub sigma: &'a [T; GLOBALS],
}

impl<T: Real> Block<'_, T> {
    /// Sets a block of three columns of node states.
    pub fn states(&mut self, from: usize, matrix: &M3<T>) {
        for (row, values) in self.rows.iter_mut().zip(matrix.row_iter()) {
            for (slot, value) in row.iter_mut().skip(from).zip(values.iter()) {
                *slot = *value * self.weight;
            }
        }
    }

    /// Sets a block of three columns of node states to a multiple of the unit matrix.
    pub fn unit(&mut self, from: usize, factor: T) {
        for (i, row) in self.rows.iter_mut().enumerate() {
            if let Some(slot) = row.get_mut(from + i) {
                *slot = factor * self.weight;
            }
        }
    }

    /// Sets the column of a global.
    pub fn global(&mut self, column: usize, by: &V3<T>) {
        let unit = self.sigma.get(column).copied().unwrap_or(T::ZERO) * self.weight;
        for (row, value) in self.rows.iter_mut().zip(by.iter()) {
            if let Some(slot) = row.get_mut(GLOBAL + column) {
                *slot = *value * unit;
            }
        }
    }

    /// Sets the columns of globals from `from` on to the coefficients of each axis.
    pub fn globals<const K: usize>(&mut self, from: usize, by: &[[T; K]; 3]) {
        for (row, values) in self.rows.iter_mut().zip(by) {
            let slots = row.iter_mut().skip(GLOBAL + from);
            for ((slot, value), unit) in slots.zip(values).zip(self.sigma.iter().skip(from)) {
                *slot = *value * *unit * self.weight;
            }
        }
    }

    /// Sets the constants of the three rows.
    pub fn constant(&mut self, value: &V3<T>) {
        for (row, value) in self.rows.iter_mut().zip(value.iter()) {
            if let Some(slot) = row.last_mut() {
                *slot = *value * self.weight;
            }
        }
    }
}
