//! Eigenvalues and eigenvectors of a small symmetric matrix, by cyclic Jacobi rotations (Golub and Van Loan,
//! Matrix Computations, section 8.5). nalgebra's solver can panic; this one always ends.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::real::Real;

/// Most sweeps; each squares what is left off the diagonal, and nine variables are done after five.
const SWEEPS: usize = 8;

/// Diagonalises a symmetric matrix, of which it reads the upper triangle alone: the diagonal then holds the
/// eigenvalues. Returns the matrix whose columns are the eigenvectors.
pub(super) fn diagonalise<T: Real, const D: usize>(a: &mut [[T; D]; D]) -> [[T; D]; D] {
    // A row for each vector: a rotation then turns elements that lie side by side.
    let mut vectors = [[T::ZERO; D]; D];
    for (i, row) in vectors.iter_mut().enumerate() {
        row[i] = T::ONE;
    }
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..D {
            for q in p + 1..D {
                rotated |= rotate(a, &mut vectors, p, q);
            }
        }
        if !rotated {
            break;
        }
    }
    let mut columns = [[T::ZERO; D]; D];
    for (k, vector) in vectors.iter().enumerate() {
        for (row, x) in columns.iter_mut().zip(vector) {
            row[k] = *x;
        }
    }
    columns
}

/// Correlation that counts as none: its square, by which it would change the diagonal, is lost in f32's rounding.
const LEAST: f32 = 1e-6;
/// Squared tangent up to which the cosine is a series of three terms: the next is 5 / 16 of its cube, 2e-9.
const SMALL: f32 = 2e-3;

/// Makes element (p, q > p) zero; `false` where it is next to nothing beside the diagonal.
#[inline(always)]
fn rotate<T: Real, const D: usize>(a: &mut [[T; D]; D], vectors: &mut [[T; D]; D], p: usize, q: usize) -> bool {
    let off = a[p][q];
    if off * off <= T::of(LEAST * LEAST) * a[p][p] * a[q][q] {
        return false;
    }
    let tau = (a[q][q] - a[p][p]) / (off + off);
    let root = (T::ONE + tau * tau).root();
    let t = T::ONE / if tau >= T::ZERO { tau + root } else { tau - root };
    let t2 = t * t;
    let c =
        if t2 < T::of(SMALL) { T::ONE - t2 * (T::of(0.5) - t2 * T::of(0.375)) } else { T::ONE / (T::ONE + t2).root() };
    let s = t * c;
    let turned = |of_p: T, of_q: T| (c * of_p - s * of_q, s * of_p + c * of_q);
    (a[p][p], a[q][q]) = (a[p][p] - t * off, a[q][q] + t * off);
    a[p][q] = T::ZERO;
    for k in 0..p {
        (a[k][p], a[k][q]) = turned(a[k][p], a[k][q]);
    }
    for k in p + 1..q {
        (a[p][k], a[k][q]) = turned(a[p][k], a[k][q]);
    }
    for k in q + 1..D {
        (a[p][k], a[q][k]) = turned(a[p][k], a[q][k]);
    }
    for k in 0..D {
        (vectors[p][k], vectors[q][k]) = turned(vectors[p][k], vectors[q][k]);
    }
    true
}

#[cfg(test)]
mod tests;
