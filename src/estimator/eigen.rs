//! Eigenvalues and eigenvectors of a small symmetric matrix, by cyclic Jacobi rotations (Golub and Van Loan,
//! Matrix Computations, section 8.5). nalgebra's solver can panic; this one always ends.

#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::real::Real;

/// Sweeps; each squares what is left off the diagonal, and nine variables are done after five.
const SWEEPS: usize = 8;

/// Makes `a` diagonal, and returns the matrix whose columns are the eigenvectors.
pub(super) fn diagonalise<T: Real, const D: usize>(a: &mut [[T; D]; D]) -> [[T; D]; D] {
    let mut v = [[T::ZERO; D]; D];
    for (i, row) in v.iter_mut().enumerate() {
        row[i] = T::ONE;
    }
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..D {
            for q in p + 1..D {
                rotated |= rotate(a, &mut v, p, q);
            }
        }
        if !rotated {
            break;
        }
    }
    v
}

/// Makes element (p, q) zero; `false` where it is next to nothing beside the diagonal: what f32 rounds.
fn rotate<T: Real, const D: usize>(a: &mut [[T; D]; D], v: &mut [[T; D]; D], p: usize, q: usize) -> bool {
    let off = a[p][q];
    if off * off <= T::of(f32::EPSILON * f32::EPSILON / 4.0) * a[p][p] * a[q][q] {
        return false;
    }
    let tau = (a[q][q] - a[p][p]) / (off + off);
    let root = (T::ONE + tau * tau).root();
    let t = if tau >= T::ZERO { T::ONE / (tau + root) } else { -T::ONE / (root - tau) };
    let c = T::ONE / (T::ONE + t * t).root();
    let s = t * c;
    let diagonal = (a[p][p] - t * off, a[q][q] + t * off);
    for k in 0..D {
        let (of_p, of_q) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (c * of_p - s * of_q, s * of_p + c * of_q);
        // It is symmetric.
        (a[p][k], a[q][k]) = (a[k][p], a[k][q]);
    }
    (a[p][p], a[q][q]) = diagonal;
    (a[p][q], a[q][p]) = (T::ZERO, T::ZERO);
    for row in v.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// Every element of A v - lambda v, over all eigenvalues, is under `bound`.
    fn assert_solved<const D: usize>(a: &[[f32; D]; D], bound: f32) {
        let mut values = *a;
        let vectors = diagonalise(&mut values);
        for k in 0..D {
            for row in 0..D {
                let product: f32 = (0..D).map(|j| a[row][j] * vectors[j][k]).sum();
                assert!((product - values[k][k] * vectors[row][k]).abs() < bound);
            }
        }
    }

    #[test]
    fn a_positive_matrix_times_its_eigenvector_is_eigenvalue_times_eigenvector() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        for _ in 0..20 {
            let mut root = [[0.0_f32; 9]; 9];
            root.as_flattened_mut().iter_mut().for_each(|x| *x = generator.next_u32() as f32 / u32::MAX as f32 - 0.5);
            let a: [[f32; 9]; 9] =
                core::array::from_fn(|i| core::array::from_fn(|j| (0..9).map(|k| root[i][k] * root[j][k]).sum()));
            assert_solved(&a, 2e-6);
        }
    }

    #[test]
    fn an_indefinite_matrix_times_its_eigenvector_is_eigenvalue_times_eigenvector() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        for _ in 0..20 {
            let mut a = [[0.0_f32; 12]; 12];
            for i in 0..12 {
                for j in 0..=i {
                    a[i][j] = generator.next_u32() as f32 / u32::MAX as f32 - 0.5;
                    a[j][i] = a[i][j];
                }
            }
            assert_solved(&a, 1e-5);
        }
    }
}
