//! The cost of a window.

use super::*;
use crate::estimator::{
    columns::{GLOBALS, P},
    rows::{GLOBAL, WIDTH},
};

/// Two nodes that know eighteen times as much of one element as a posterior whose every deviation is 0.1.
fn rows() -> LeftOver<WINDOW_NODES> {
    let mut rows = LeftOver::zero();
    for constant in [1.0, -1.0] {
        let mut left = [[0.0_f64; WIDTH]; ROWS];
        (left[0][GLOBAL + P.from], left[1][GLOBAL + P.from + 4]) = (30.0, 3.0);
        left[0][WIDTH - 1] = constant;
        rows.push(&left, &[0.0; GLOBALS]);
    }
    rows
}

#[test]
fn no_point_of_the_search_box_costs_less_than_the_mean_of_nodes_that_are_all_alike() {
    let rows = rows();
    let mut covariance = [0.0; 78];
    (0..GYRO).for_each(|i| covariance[i * (i + 3) / 2] = 0.01);
    let mut centre = Centre::new(&rows, &[0.0; GYRO], &covariance, 1.0).unwrap();
    let lowest = |centre: &Centre| {
        let cost =
            WindowCost { rows: &rows, centre, base: GyroModel::IDENTITY, sigma: [0.01; GYRO], steps: Vector3::zeros() };
        let along = |k: usize, y: f32| cost.evaluate(&core::array::from_fn(|i| if i == k { y } else { 0.0 }));
        let far = (0..GYRO).flat_map(|k| [-10.0, -3.0, 3.0, 10.0].map(|y| along(k, y)));
        far.reduce(|least, cost| if cost < least { cost } else { least }).unwrap() - cost.evaluate(&[0.0; GYRO])
    };
    let before = lowest(&centre);
    assert!(before < -10.0, "{before}");
    let mut left = GyroInformation::zero();
    gather(&rows, 0..rows.count(), &mut left);
    centre.bound(&left);
    let after = lowest(&centre);
    assert!(after > 0.0 && centre.share > 0.03, "{after} {}", centre.share);
}

/// A scale whose deviation is a hundredth of a turn's, and which would be known far better still at a given turn.
#[test]
fn a_covariance_that_rounding_has_made_singular_still_has_a_cost() {
    let mut covariance = [0.0; 78];
    (0..GYRO).for_each(|i| covariance[i * (i + 3) / 2] = 0.01);
    // Unknowns 0 and 1: variances 0.01 and 1e-6, and a covariance that is too large by a two-millionth of the first.
    (covariance[1], covariance[2]) = (1.0002e-4, 1e-6);
    assert!(information(&covariance, 0.0).is_none());
    let centre = Centre::new(&rows(), &[0.0; GYRO], &covariance, 1.0).unwrap();
    // Deviations of the covariance that is meant, where its factor's inverse has them.
    let variance = |k: usize| {
        let unit: [f32; GYRO] = core::array::from_fn(|i| f32::from(u8::from(i == k)));
        let whitened = centre.factor.solve_lower(&unit);
        dot(&whitened, &whitened)
    };
    for (k, expected) in [(0, 0.01), (1, 1e-6), (2, 0.01)] {
        assert!((variance(k) - expected).abs() < 0.05 * expected, "{k}: {}", variance(k));
    }
}
