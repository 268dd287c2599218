#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]
use super::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

#[test]
fn the_root_has_the_information_of_the_rows_and_what_is_left_the_residual() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
    let mut rows = [[0.0_f64; 5]; 9];
    for value in rows.as_flattened_mut() {
        *value = f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.4;
    }
    rows[3] = [0.0; 5];
    let product = |rows: &[[f64; 5]], i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
    let before: [[f64; 5]; 5] = core::array::from_fn(|i| core::array::from_fn(|j| product(&rows, i, j)));
    for column in 0..4 {
        reflect_first(&mut rows[column..], column);
    }
    for i in 0..5 {
        for j in 0..5 {
            assert!((product(&rows, i, j) - before[i][j]).abs() < 1e-12);
        }
        for row in rows.iter().skip(i + 1).filter(|_| i < 4) {
            assert!(row[i].abs() < 1e-15);
        }
    }
}
