#![allow(clippy::indexing_slicing)]
use super::*;
use nalgebra::{Matrix4, Vector4};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn factor_solutions_and_determinant_are_those_of_the_matrix() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(4);
    let mut uniform = || f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
    let root = Matrix4::from_fn(|_, _| uniform());
    let matrix = root * root.transpose() + Matrix4::identity() * 0.1;
    let right = Vector4::from_fn(|_, _| uniform());
    let factor = Cholesky::<f64, 6>::new(4, |i, j| matrix[(i, j)]).unwrap();
    let mut x = [0.0; 6];
    x[..4].copy_from_slice(right.as_slice());
    factor.solve_lower(&mut x);
    factor.solve_upper(&mut x);
    let inverse = matrix.try_inverse().unwrap();
    assert!((Vector4::from_column_slice(&x[..4]) - inverse * right).amax() < 1e-12);
    assert!((0..4).all(|i| (factor.inverse_diagonal(i) - inverse[(i, i)]).abs() < 1e-12));
    assert!((factor.half_log_determinant() - 0.5 * matrix.determinant().ln()).abs() < 1e-12);
}

#[test]
fn a_pivot_that_is_not_positive_is_refused_or_replaced() {
    let singular = |_: usize, _: usize| 1.0_f64;
    assert!(Cholesky::<f64, 2>::new(2, singular).is_none());
    assert_eq!(Cholesky::<f64, 2>::new_or_least(2, singular, 1e-3).at(1, 1), 1e-3);
}
