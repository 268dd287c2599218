//! Columns that an unturned axis hides: what the readings seem to say of them does not count, and what a declared field
//! tells of them is the evidence of its own two rows.

#![allow(clippy::single_range_in_vec_init)] // A list of one range of columns.

extern crate std;

use super::{
    super::{Misfit, Rules, Unturned},
    OF_IRON, deviate,
    problem::{Problem, columns_of},
};
use crate::estimator::{
    columns::{ALONG, GLOBALS, HARD_IRON, MAG_MATRIX, MAG_SHAPE, MAG_TURN},
    rows::ReferenceRows,
};
use nalgebra::{Matrix2, Vector2};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

const NEVER: Rules = Rules { least: 1e30, with_nuisances: false };
const ALONG_THE_TOOL: [bool; 3] = [false, false, true];
const IRON: usize = HARD_IRON.from + 2;
/// Columns without a name that the tool's own axis hides beside its iron.
const NAMELESS: [usize; 2] = [MAG_TURN.from, MAG_SHAPE.from + ALONG];

/// Iron on all axes.
fn problem(seed: u64) -> Problem {
    Problem::new(seed, &[(HARD_IRON.from, 2.0), (HARD_IRON.from + 1, -2.0), (IRON, 2.5)], |_, _| ())
}

/// Columns that are hidden.
const HIDDEN: [usize; 3] = [NAMELESS[0], NAMELESS[1], IRON];

/// Sum that the columns that are not hidden add to each row.
fn of_others(rows: &ReferenceRows<f64>, present: &[f64]) -> [f64; 2] {
    rows.by.map(|row| (0..11).filter(|c| !HIDDEN.contains(c)).map(|c| row[c] * present[c]).sum())
}

/// Rows with random coefficients that tell the truth if the iron along the tool is `iron`; `present`: the estimates.
fn rows_of(seed: u64, iron: f64, present: &[f64]) -> ReferenceRows<f64> {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let by: [[f64; 11]; 2] = core::array::from_fn(|_| core::array::from_fn(|_| 2.0 * deviate(&mut generator)));
    let at = by.map(|row| deviate(&mut generator) - row[IRON] * iron);
    let others = of_others(&ReferenceRows { by, constants: [0.0; 2] }, present);
    ReferenceRows { by, constants: [at[0] - others[0], at[1] - others[1]] }
}

/// Evidence of the two rows for iron along the tool; the other hidden errors have this variance.
fn of_rows(rows: &ReferenceRows<f64>, present: &[f64], usual: f64) -> f64 {
    let column = |c: usize| Vector2::new(rows.by[0][c], rows.by[1][c]);
    let misfit = Vector2::from(rows.constants) + Vector2::from(of_others(rows, present));
    let square = |c: usize| column(c) * column(c).transpose();
    let without = NAMELESS.iter().fold(Matrix2::identity(), |sum, c| sum + square(*c) * usual);
    let likelihood = |covariance: Matrix2<f64>| {
        -0.5 * (misfit.dot(&(covariance.try_inverse().unwrap() * misfit)) + libm::log(covariance.determinant()))
    };
    likelihood(without + square(IRON)) - likelihood(without)
}

/// Mean square of the magnetometer's matrix as its other columns show it, each beside the gyro and the hidden ones
/// alone.
fn usual(problem: &Problem) -> f64 {
    let present = problem.known.globals.x;
    let shown: Vec<f64> = MAG_MATRIX
        .columns()
        .filter(|column| !NAMELESS.contains(column))
        .map(|column| (present[column] * present[column] + problem.variance_beside_gyro(column, &HIDDEN)).min(1.0))
        .collect();
    shown.iter().sum::<f64>() / shown.len() as f64
}

#[test]
fn the_evidence_of_a_hidden_column_is_that_of_the_declared_field_alone() {
    for seed in 0..6 {
        let mut problem = problem(seed);
        problem.weigh(&NEVER);
        let of_readings = problem.evidence.choice.tried[OF_IRON];
        let across = problem.likelihood(&[columns_of(OF_IRON)]) - problem.likelihood(&[IRON..IRON + 1]);

        problem.weigh_unturned(&NEVER, Unturned { axes: ALONG_THE_TOOL, reference: None });
        let without = f64::from(problem.evidence.choice.tried[OF_IRON]);
        assert!((without - across).abs() < 1e-4 * across, "{seed}: {without}, {across}");
        assert!(f64::from(of_readings) > across + 3.0, "{seed}: the iron along the tool shows: {of_readings}");

        let present = problem.known.globals.x;
        let rows = rows_of(seed, 1.5, &present);
        problem.weigh_unturned(&NEVER, Unturned { axes: ALONG_THE_TOOL, reference: Some(rows) });
        let found = f64::from(problem.evidence.choice.tried[OF_IRON]);
        let expected = across + of_rows(&rows, &present, usual(&problem));
        assert!((found - expected).abs() < 1e-4 * expected.abs(), "{seed}: {found}, {expected}");
    }
}

#[test]
fn the_size_along_an_unturned_axis_is_the_declared_fields_whatever_the_readings_say() {
    for seed in 0..6 {
        let mut problem = problem(seed);
        problem.weigh(&NEVER);
        let rules = Rules { least: 5.0, with_nuisances: false };
        let size = |problem: &Problem, k: usize| {
            let claim = problem.evidence.account.claims.iter().find(|claim| usize::from(claim.effect) == OF_IRON);
            claim.map(|claim| f64::from(claim.parameters[k]) / problem.sigma[HARD_IRON.from + k])
        };
        for iron in [-3.0, 0.0, 3.0] {
            // Rows that tell of the iron alone, to 0.1.
            let mut rows = ReferenceRows { by: [[0.0; 11]; 2], constants: [0.0; 2] };
            rows.by[0][IRON] = 10.0;
            rows.constants[0] = -10.0 * iron;
            problem.weigh_unturned(&rules, Unturned { axes: ALONG_THE_TOOL, reference: Some(rows) });
            let along = size(&problem, 2).unwrap();
            assert!((along - iron).abs() < 0.1, "{seed}: {along}, {iron}");
            // That of the others is the readings'.
            assert!((size(&problem, 0).unwrap() - 2.0).abs() < 0.8, "{seed}: {:?}", size(&problem, 0));
        }
        // Twice without anything that tells: it stays hidden though the iron was claimed.
        for _ in 0..2 {
            problem.weigh_unturned(&rules, Unturned { axes: ALONG_THE_TOOL, reference: None });
            assert!(size(&problem, 2).unwrap().abs() < 1e-6, "{seed}: {:?}", size(&problem, 2));
        }
    }
}

#[test]
fn iron_that_was_claimed_while_its_axis_turned_stays() {
    let mut problem = problem(3);
    let rules = Rules { least: 5.0, with_nuisances: false };
    problem.weigh(&rules);
    let claimed = problem.evidence.account.claims[0];
    problem.weigh_unturned(&rules, Unturned { axes: ALONG_THE_TOOL, reference: None });
    assert_eq!(problem.evidence.account.claims[0], claimed);
}

#[test]
fn the_certainty_of_the_declared_field_does_not_follow_from_the_noise_of_the_readings() {
    for dispersion in [0.5, 4.0] {
        let mut problem = problem(4);
        problem.weigh(&NEVER);
        let mut rows = ReferenceRows { by: [[0.0; 11]; 2], constants: [0.0; 2] };
        rows.by[0][IRON] = 10.0;
        rows.constants[0] = -10.0 * 3.0;
        let rules = Rules { least: 5.0, with_nuisances: false };
        let unturned = Unturned { axes: ALONG_THE_TOOL, reference: Some(rows) };
        problem.weigh_as(&rules, Misfit { dispersion, is_unexplained: false }, unturned);
        let sigma = f64::from(problem.evidence.account.claims[0].sigma[2]) / problem.sigma[IRON];
        assert!((sigma - 0.1).abs() < 0.01, "{dispersion}: {sigma}");
    }
}

#[test]
fn a_field_beyond_what_hidden_errors_explain_is_wrong() {
    for seed in 0..6 {
        let mut x = [0.0; GLOBALS];
        x.iter_mut().enumerate().for_each(|(c, x)| *x = 0.3 - 0.05 * c as f64);
        let mut rows = rows_of(seed, 0.0, &x);
        let column = |c: usize| Vector2::new(rows.by[0][c], rows.by[1][c]);
        let covariance = HIDDEN.iter().fold(Matrix2::identity(), |sum, c| sum + column(*c) * column(*c).transpose());
        let misfit = Vector2::from(rows.constants) + Vector2::from(of_others(&rows, &x));
        let deviations = misfit.dot(&(covariance.try_inverse().unwrap() * misfit)).sqrt();
        // As many deviations as are too many, and fewer.
        for (times, is_explained) in [(5.01, false), (4.99, true)] {
            let misfit = misfit * (times / deviations) - Vector2::from(of_others(&rows, &x));
            rows.constants = [misfit[0], misfit[1]];
            let unturned = Unturned { axes: ALONG_THE_TOOL, reference: Some(rows) };
            assert_eq!(unturned.explains_the_field(&x), is_explained, "{seed}: {times}");
        }
    }
}
