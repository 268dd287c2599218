//! Packed symmetric matrices and their Cholesky factors.

use super::*;
use crate::algebra::dot;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

fn random_rows(seed: u64) -> [[f32; 5]; 9] {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    [[0.0; 5]; 9].map(|row| row.map(|_: f32| generator.next_u32() as f32 / u32::MAX as f32 - 0.5))
}

#[test]
fn solving_undoes_multiplying() {
    for seed in 0..50 {
        let mut n = Packed::<5, 15>::zero();
        for row in random_rows(seed) {
            n.add_outer(&row, 2.0);
        }
        let x = random_rows(seed + 1000)[0];
        let l = n.cholesky().unwrap();
        for (solved, expected) in l.solve(&n.times(&x)).iter().zip(&x) {
            assert!((solved - expected).abs() < 2e-3, "{solved} {expected}");
        }
        let whitened = l.times_upper(&x);
        for (back, expected) in l.solve_upper(&whitened).iter().zip(&x) {
            assert!((back - expected).abs() < 1e-5);
        }
        // |L^T x|^2 = x^T N x.
        assert!((dot(&whitened, &whitened) - dot(&x, &n.times(&x))).abs() < 1e-5);
    }
}

#[test]
fn a_singular_or_non_finite_matrix_has_no_factor() {
    let mut n = Packed::<5, 15>::zero();
    assert!(n.cholesky().is_none());
    n.add_outer(&[1.0, 2.0, 3.0, 4.0, 5.0], 1.0);
    assert!(n.cholesky().is_none());
    n.add(0, 0, f32::NAN);
    assert!(n.cholesky().is_none());
}
