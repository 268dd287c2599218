//! Derivatives of a node's sums, against differences of the sums.

use super::*;
use crate::estimator::columns::{HARD_IRON, MAG_LAG, MAG_MATRIX};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Sum of the fields of ten increments, drawn at random, with these errors of the magnetometer; and its derivatives by
/// matrix (row-major), iron and lag.
fn sums(matrix: &M3<f64>, iron: &V3<f64>, lag: f64) -> (V3<f64>, [V3<f64>; 13]) {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(11);
    let mut three =
        |size: f64| V3::from_fn(|_, _| size * (f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5));
    let mut x = [0.0; GLOBALS];
    x[MAG_LAG.from] = lag;
    let with = Parameters { mag_matrix: *matrix, hard_iron: *iron, ..Parameters::new(&x, &zero3(), identity()) };
    let mut pre = Preintegration::zero();
    pre.start();
    for _ in 0..10 {
        let rate = three(20.0);
        let increment = Increment {
            end_us: 0,
            seconds: 0.04,
            rate,
            force: None,
            field: Some(three(2.0)),
            vibration: 0.0,
            mean_rate: rate,
            rate_variance: zero3(),
            square_force: 0.0,
            peak: 0.0,
            warming_k: None,
            unread_turn: 0.0,
            unread_velocity: 0.0,
        };
        pre.add(&increment, &zero3(), None, &with, &TakenOut::nothing());
    }
    let mut by = [zero3(); 13];
    by[..9].copy_from_slice(&pre.field_by_matrix);
    for (by, column) in by[9..12].iter_mut().zip(pre.field_by_iron.column_iter()) {
        *by = column.into();
    }
    by[12] = pre.field_by_lag;
    (pre.field, by)
}

/// A magnetometer that is late, whose matrix and iron are off: all act before the lag does.
#[test]
fn the_fields_derivatives_are_those_of_a_late_magnetometer() {
    assert_eq!((MAG_MATRIX.count, HARD_IRON.count), (8, 3));
    let matrix = M3::new(1.03, 0.02, -0.01, 0.01, 0.97, 0.02, -0.03, 0.01, 1.01);
    let (iron, lag) = (V3::new(0.2, -0.1, 0.15), 0.012);
    let (_, by) = sums(&matrix, &iron, lag);
    const STEP: f64 = 1e-6;
    for (k, by) in by.iter().enumerate() {
        let shifted = |step: f64| {
            let (mut matrix, mut iron, mut lag) = (matrix, iron, lag);
            match k {
                0..9 => matrix[(k / 3, k % 3)] += step,
                9..12 => iron[k - 9] += step,
                _ => lag += step,
            }
            sums(&matrix, &iron, lag).0
        };
        let difference = (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP);
        assert!((difference - by).norm() < 1e-6 * (1.0 + by.norm()), "{k}: {difference:?} {by:?}");
    }
}
