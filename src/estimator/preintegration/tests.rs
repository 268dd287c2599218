//! Derivatives of a node's sums, against differences of the sums.

use super::*;
use crate::estimator::columns::{ACCEL_LAG, BIAS, HARD_IRON, MAG_LAG, MAG_MATRIX};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Errors of magnetometer and gyro.
#[derive(Clone, Copy)]
struct Errors {
    matrix: M3<f64>,
    iron: V3<f64>,
    lag: f64,
    bias: V3<f64>,
    p: M3<f64>,
}

/// An increment of 40 ms that reads nothing but this rate.
fn turned(rate: V3<f64>) -> Increment<f64> {
    Increment {
        end_us: 0,
        seconds: 0.04,
        rate,
        force: None,
        field: None,
        vibration: 0.0,
        mean_rate: rate,
        rate_variance: zero3(),
        square_force: 0.0,
        peak: 0.0,
        warming_k: None,
        unread_turn: 0.0,
        unread_velocity: 0.0,
    }
}

/// Sum of the fields of ten increments, drawn at random, with these errors; and its derivatives by matrix (row-major),
/// iron, lag, bias and P (row-major).
fn sums(errors: &Errors) -> (V3<f64>, [V3<f64>; 25]) {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(11);
    let mut three =
        |size: f64| V3::from_fn(|_, _| size * (f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5));
    let mut x = [0.0; GLOBALS];
    x[MAG_LAG.from] = errors.lag;
    for (x, bias) in x[BIAS.from..].iter_mut().zip(errors.bias.iter()) {
        *x = *bias;
    }
    let Errors { matrix: mag_matrix, iron: hard_iron, p, .. } = *errors;
    let with = Parameters { mag_matrix, hard_iron, ..Parameters::new(&x, &zero3(), p) };
    let mut pre = Preintegration::zero();
    pre.start();
    for _ in 0..10 {
        let rate = three(4.0);
        let increment = Increment { field: Some(three(2.0)), ..turned(rate) };
        pre.add(&increment, &zero3(), None, &with, &TakenOut::nothing());
    }
    let mut by = [zero3(); 25];
    by[..9].copy_from_slice(&pre.field_by_matrix);
    for (by, column) in by[9..12].iter_mut().zip(pre.field_by_iron.column_iter()) {
        *by = column.into();
    }
    by[12] = pre.field_by_lag;
    by[13..].copy_from_slice(&pre.field_by_gyro);
    (pre.field, by)
}

/// A magnetometer that is late: its matrix and iron act before the lag does, and the gyro turns the field within it.
#[test]
fn the_fields_derivatives_are_those_of_a_late_magnetometer() {
    assert_eq!((MAG_MATRIX.count, HARD_IRON.count), (8, 3));
    let errors = Errors {
        matrix: M3::new(1.03, 0.02, -0.01, 0.01, 0.97, 0.02, -0.03, 0.01, 1.01),
        iron: V3::new(0.2, -0.1, 0.15),
        lag: 0.012,
        bias: V3::new(0.02, -0.03, 0.01),
        p: M3::new(0.96, 0.03, -0.02, -0.01, 1.05, 0.02, 0.03, -0.02, 1.02),
    };
    let (_, by) = sums(&errors);
    const STEP: f64 = 1e-6;
    for (k, by) in by.iter().enumerate() {
        let shifted = |step: f64| {
            let mut errors = errors;
            match k {
                0..9 => errors.matrix[(k / 3, k % 3)] += step,
                9..12 => errors.iron[k - 9] += step,
                12 => errors.lag += step,
                13..16 => errors.bias[k - 13] += step,
                _ => errors.p[((k - 16) / 3, (k - 16) % 3)] += step,
            }
            sums(&errors).0
        };
        let difference = (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP);
        // Derivatives by a rotation are exact to the first order of an increment's angle.
        let least = if k < 13 { 1e-6 } else { 0.01 };
        assert!((difference - by).norm() < least * (1.0 + by.norm()), "{k}: {difference:?} {by:?}");
    }
}

/// An accelerometer that is late, while predicted gravity multiplies its errors: the velocity's derivative by the lag,
/// and the lag's whole effect against a gravity that is read later.
#[test]
fn a_late_accelerometer_reads_gravity_as_it_was() {
    let (lag, gravity) = (0.012, V3::new(3.0, -2.0, 9.0));
    let rate = V3::new(0.5, -1.0, 12.0);
    let velocity = |assumed_lag: f64| {
        let mut x = [0.0; GLOBALS];
        x[ACCEL_LAG.from] = assumed_lag;
        let with = Parameters::new(&x, &zero3(), identity());
        let mut pre = Preintegration::zero();
        pre.start();
        for k in 0..25 {
            let late_s = 0.04 * (f64::from(k) + 0.5) - lag;
            let force = Some(rotation(&(rate * late_s)).transpose() * gravity);
            let increment = Increment { force, ..turned(rate) };
            pre.add(&increment, &zero3(), Some(&gravity), &with, &TakenOut::nothing());
        }
        pre.velocity
    };
    const STEP: f64 = 1e-6;
    let difference = (velocity(lag + STEP).value - velocity(lag - STEP).value) / (2.0 * STEP);
    let found = velocity(lag);
    assert!((difference - found.by_lag).norm() < 1e-6 * found.by_lag.norm(), "{difference:?} {:?}", found.by_lag);
    // The rest is of the third order: 0.144^3 / 6 of gravity across the axis.
    let left = (found.value - gravity).norm();
    assert!(left < 0.005, "{left}");
    assert!((velocity(0.0).value - gravity).norm() > 0.3, "else nothing is shown");
}
