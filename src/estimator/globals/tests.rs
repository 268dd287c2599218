//! Process noise of one global, against the covariance of all in double precision.

use super::*;
use nalgebra::SMatrix;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

fn covariance(globals: &Globals<f64>) -> SMatrix<f64, GLOBALS, GLOBALS> {
    let r = SMatrix::<f64, GLOBALS, GLOBALS>::from_fn(|i, j| globals.root[i][j]);
    (r.transpose() * r).try_inverse().unwrap()
}

#[test]
fn process_noise_adds_the_variance_to_one_global_and_changes_no_other_covariance() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(2);
    let mut globals = Globals::<f64>::zero();
    globals.start();
    for (i, row) in globals.root.iter_mut().enumerate() {
        for x in row.iter_mut().take(GLOBALS).skip(i) {
            *x += f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
        }
        row[i] += 2.0;
    }
    let before = covariance(&globals);
    let noises = [(3, 0.7), (25, 0.01), (36, 4.0)];
    for (global, variance) in noises {
        let (u, beta) = globals.process_noise(global, variance).unwrap();
        globals.add_process_noise(&u, beta);
    }
    let mut candidates = crate::estimator::candidates::Candidates::<f64, 0>::zero();
    (0..GLOBALS).for_each(|column| candidates.triangular(&mut globals, column));
    for i in 0..GLOBALS {
        assert!(globals.root[i].iter().take(i).all(|x| *x == 0.0));
    }
    let mut expected = before;
    for (global, variance) in noises {
        expected[(global, global)] += variance;
    }
    assert!((covariance(&globals) - expected).amax() < 1e-12);
}

#[test]
fn a_drift_adds_variance_to_one_global_and_draws_its_mean_to_the_priors() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
    let mut globals = Globals::<f64>::zero();
    globals.start();
    for (i, row) in globals.root.iter_mut().enumerate() {
        for x in row.iter_mut().take(GLOBALS).skip(i) {
            *x += f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
        }
        row[i] += if i % 3 == 0 { -4.0 } else { 2.0 };
    }
    globals.x = core::array::from_fn(|i| i as f64);
    let mut expected = covariance(&globals);
    let drifted = [(2, 0.9), (0, 0.5), (9, 0.0), (30, 0.99), (36, 0.0), (20, 1.0)];
    for (global, kept) in drifted {
        globals.relax(global, kept);
        expected.row_mut(global).scale_mut(kept);
        expected.column_mut(global).scale_mut(kept);
        expected[(global, global)] += 1.0 - kept * kept;
    }
    for (i, row) in globals.root.iter().enumerate() {
        assert!(row.iter().take(i).all(|x| *x == 0.0), "row {i}");
    }
    assert!((covariance(&globals) - expected).amax() < 1e-12);
    for (i, x) in globals.x.iter().enumerate() {
        let kept = drifted.iter().find(|(global, _)| *global == i).map_or(1.0, |(_, kept)| *kept);
        assert_eq!(*x, kept * i as f64);
    }
    // Nothing is left of what is forgotten.
    assert!(globals.root[9].iter().enumerate().all(|(c, x)| (*x == 1.0) == (c == 9)));
}
