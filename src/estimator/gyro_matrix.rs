//! The gyro matrix that its nine unknowns D make of the prior's centre C: P = exp([a]x) (I + S) C, with [a]x the
//! antisymmetric and S the symmetric part of D.
//!
//! To first order that is (I + D) C. A turn of the axes of all sensors together shows in no reading. In I + D it would
//! change the scales, by its square, and the scales are known a hundred times better than the turn: rows that are made
//! linear at one turn after the other would seem to measure it. In exp([a]x) a turn of any size leaves the scales
//! alone.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loop around it.

use super::real::{M3, Real, V3, cross_matrix, identity, rotation, zero33};
use nalgebra::Matrix3;

/// Steps in which the unknowns of a P are found: each leaves as much of the error as they are large.
const STEPS: u8 = 10;

/// P, and the turn in it.
pub(super) struct GyroMatrix<T> {
    /// P.
    pub p: M3<T>,
    /// a, rad.
    vector: V3<T>,
    /// exp([a]x).
    turn: M3<T>,
}

impl<T: Real> GyroMatrix<T> {
    /// Makes P of its unknowns, row-major, and of its centre.
    #[inline(never)]
    pub fn new(d: &[T; 9], centre: &M3<T>) -> Self {
        let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *d;
        let half = T::of(0.5);
        let (sxy, sxz, syz) = ((xy + yx) * half, (xz + zx) * half, (yz + zy) * half);
        let stretch = Matrix3::new(xx, sxy, sxz, sxy, yy, syz, sxz, syz, zz);
        let vector = V3::new(zy - yz, xz - zx, yx - xy) * half;
        let turn = rotation(&vector);
        Self { p: product(&turn, &(centre + product(&stretch, centre))), vector, turn }
    }

    /// Makes, of derivatives by the nine elements of P, those by its unknowns; both row-major.
    #[inline(never)]
    pub fn by_unknowns(&self, centre: &M3<T>, by: &mut [V3<T>; 9]) {
        let half = T::of(0.5);
        for component in 0..3 {
            // Column-major, so that rows of derivatives become columns.
            let mut elements = zero33();
            for (slot, by) in elements.iter_mut().zip(by.iter()) {
                *slot = by[component];
            }
            // A turn by v adds [v]x P to P.
            let w = product(&self.p, &elements);
            let by_turn = V3::new(w.m23 - w.m32, w.m31 - w.m13, w.m12 - w.m21);
            // Slope of the turn by its vector; the next term is |a|^3 / 24, 4e-5 at 0.1 rad.
            let once = by_turn.cross(&self.vector);
            let by_turn = by_turn + once * half + once.cross(&self.vector) * T::of(1.0 / 6.0);
            // A stretch by S adds exp([a]x) S C.
            let stretched = product(centre, &product(&elements, &self.turn));
            let all = stretched + stretched.transpose() - cross_matrix(&by_turn);
            for (by, x) in by.iter_mut().zip(all.iter()) {
                by[component] = *x * half;
            }
        }
    }
}

/// Product of two matrices, once in the program.
#[inline(never)]
fn product<T: Real>(a: &M3<T>, b: &M3<T>) -> M3<T> {
    a * b
}

/// Unknowns, row-major, of a P about its centre: undoes [`GyroMatrix::new`].
pub(super) fn unknowns(p: &M3<f32>, centre: &M3<f32>) -> [f32; 9] {
    let inverse = centre.try_inverse().unwrap_or_else(identity);
    let mut d = [0.0; 9];
    for _ in 0..STEPS {
        let left = product(&(p - GyroMatrix::new(&d, centre).p), &inverse);
        for (d, left) in d.iter_mut().zip(left.transpose().iter()) {
            *d += left;
        }
    }
    d
}

#[cfg(test)]
mod tests;
