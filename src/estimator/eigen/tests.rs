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
