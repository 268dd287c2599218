//! Symmetric matrices, stored as lower triangles: half of the memory, and no half that could disagree.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::packed_cholesky::{factorise, solve_lower, solve_upper};
use core::ops::Range;

/// Symmetric D x D matrix, lower triangle row by row: element (i, j <= i) at i (i + 1) / 2 + j. `T` must be D
/// (D + 1) / 2.
#[derive(Clone, Copy, Debug)]
pub struct Packed<const D: usize, const T: usize>(pub(crate) [f32; T]);

/// Lower Cholesky factor L of a positive-definite matrix N = L L^T, packed as [`Packed`], with inverted
/// diagonal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PackedCholesky<const D: usize, const T: usize>([f32; T]);

const fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// Reads element (i, j <= i). The compiler cannot bound a triangle's index, so an index out of range, which
/// the sizes exclude, reads 0 instead of panicking.
fn read(elements: &[f32], i: usize, j: usize) -> f32 {
    elements.get(at(i, j)).copied().unwrap_or(0.0)
}

fn write(elements: &mut [f32], i: usize, j: usize, value: f32) {
    if let Some(element) = elements.get_mut(at(i, j)) {
        *element = value;
    }
}

/// Adds `weight * row row^T` of three rows to a lower triangle, reading and writing each sum once.
#[inline(never)]
pub(crate) fn add_outers(triangle: &mut [f32], [a, b, c]: [&[f32]; 3], weight: f32) {
    let mut rest = triangle;
    for length in 1..=a.len() {
        // Slices of equal length, so that the compiler need not look for the shortest.
        let (Some(a), Some(b), Some(c)) = (a.get(..length), b.get(..length), c.get(..length)) else { return };
        let Some((sums, next)) = core::mem::take(&mut rest).split_at_mut_checked(length) else { return };
        let [wa, wb, wc] = [a, b, c].map(|row| weight * row.last().copied().unwrap_or(0.0));
        for (((sum, x), y), z) in sums.iter_mut().zip(a).zip(b).zip(c) {
            *sum += wa * x + wb * y + wc * z;
        }
        rest = next;
    }
}

impl<const D: usize, const T: usize> Packed<D, T> {
    const SIZES_AGREE: () = assert!(T == D * (D + 1) / 2);

    /// Returns the zero matrix. Does not compile if `T` is not D (D + 1) / 2.
    #[must_use]
    pub const fn zero() -> Self {
        #[allow(clippy::let_unit_value)]
        let () = Self::SIZES_AGREE;
        Self([0.0; T])
    }

    /// Returns element (i, j); 0 out of range.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> f32 {
        if j <= i { read(&self.0, i, j) } else { read(&self.0, j, i) }
    }

    /// Adds `value` to element (i, j) and, by symmetry, to (j, i).
    pub fn add(&mut self, i: usize, j: usize, value: f32) {
        let (i, j) = if j <= i { (i, j) } else { (j, i) };
        let sum = read(&self.0, i, j) + value;
        write(&mut self.0, i, j, sum);
    }

    /// Adds `weight * row row^T`.
    pub fn add_outer(&mut self, row: &[f32; D], weight: f32) {
        let mut rest = self.0.as_mut_slice();
        for (i, factor) in row.iter().enumerate() {
            let Some((sums, next)) = core::mem::take(&mut rest).split_at_mut_checked(i + 1) else { return };
            let scaled = weight * factor;
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += scaled * value;
            }
            rest = next;
        }
    }

    /// Adds `weight * row row^T` of three rows.
    pub(crate) fn add_outers(&mut self, [a, b, c]: &[[f32; D]; 3], weight: f32) {
        add_outers(&mut self.0, [a, b, c], weight);
    }

    #[cfg(test)]
    pub(crate) fn times(&self, x: &[f32; D]) -> [f32; D] {
        let [y, ..] = self.times_within(&[*x, [0.0; D], [0.0; D]], 0..D);
        y
    }

    /// The products with three vectors that are zero outside of a range. Each element is loaded once for all three.
    #[inline(never)]
    pub(crate) fn times_within(&self, x: &[[f32; D]; 3], range: Range<usize>) -> [[f32; D]; 3] {
        // By element, then by vector.
        let mut of = [[0.0; 3]; D];
        for (k, vector) in x.iter().enumerate() {
            of.iter_mut().zip(vector).for_each(|(of, x)| of[k] = *x);
        }
        let mut y = [[0.0; 3]; D];
        let mut rest = self.0.as_slice();
        for (i, own) in of.iter().enumerate() {
            let Some((row, next)) = rest.split_at_checked(i + 1) else { break };
            let Some((diagonal, below)) = row.split_last() else { break };
            let end = if i < range.end { i } else { range.end };
            let a = below.get(range.start..end).unwrap_or_default();
            let x = of.get(range.start..end).unwrap_or_default();
            let mut sum = own.map(|own| diagonal * own);
            for (a, x) in a.iter().zip(x) {
                sum = [sum[0] + a * x[0], sum[1] + a * x[1], sum[2] + a * x[2]];
            }
            if range.contains(&i) {
                for (a, y) in below.iter().zip(&mut y) {
                    *y = [y[0] + a * own[0], y[1] + a * own[1], y[2] + a * own[2]];
                }
            }
            y[i] = [y[i][0] + sum[0], y[i][1] + sum[1], y[i][2] + sum[2]];
            rest = next;
        }
        core::array::from_fn(|k| core::array::from_fn(|i| y[i][k]))
    }

    /// Returns the Cholesky factor; `None` if the matrix is not finite or not positive definite to f32's
    /// precision.
    pub(crate) fn cholesky(&self) -> Option<PackedCholesky<D, T>> {
        let mut factor = PackedCholesky(self.0);
        factorise(&mut factor.0)?;
        Some(factor)
    }
}

impl<const D: usize, const T: usize> PackedCholesky<D, T> {
    /// Solves N x = rhs.
    pub fn solve(&self, rhs: &[f32; D]) -> [f32; D] {
        self.solve_upper(&self.solve_lower(rhs))
    }

    /// Solves L y = rhs.
    pub fn solve_lower(&self, rhs: &[f32; D]) -> [f32; D] {
        let mut y = *rhs;
        solve_lower(&self.0, &mut y);
        y
    }

    /// Solves L^T x = rhs: maps whitened coordinates to parameters.
    pub fn solve_upper(&self, rhs: &[f32; D]) -> [f32; D] {
        let mut x = *rhs;
        solve_upper(&self.0, &mut x);
        x
    }

    /// Returns L^T x: maps parameters to whitened coordinates.
    pub fn times_upper(&self, x: &[f32; D]) -> [f32; D] {
        let mut y = [0.0; D];
        for i in 0..D {
            y[i] = x[i] / read(&self.0, i, i);
            for k in i + 1..D {
                y[i] += read(&self.0, k, i) * x[k];
            }
        }
        y
    }
}

#[cfg(test)]
mod tests;
