//! The average beside effects that are taken out.

extern crate std;

use super::*;
use crate::estimator::{
    columns::{BIAS, P},
    globals::WIDE,
    update::Update,
    widths::Widths,
};
use nalgebra::{SMatrix, SVector};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::boxed::Box;

/// Without a rest the bias is averaged over the scales of its prior. That average is over before the effects'
/// uncertainty is added.
#[test]
fn what_is_not_known_of_an_effect_moves_no_mean_whether_or_not_a_rest_has_measured_the_bias() {
    for is_bias_measured in [false, true] {
        let mut averaging = Averaging::<f64>::zero();
        averaging.grid = Widths { parts: [[1.0; 3]; GROUPS], ..Widths::HAND };
        let mut of = Gaussian { mean: [0.0; GYRO], covariance: [0.0; triangle(GYRO)] };
        (0..GYRO).for_each(|i| of.covariance[triangle(i) + i] = if i < NINE { 0.25 } else { 1e-4 });
        of.covariance[triangle(NINE)] = 2e-3;
        of.mean[NINE..].fill(0.1);
        averaging.sum.add(&of, &[1.0], 0.0, [0.0; GROUPS]);
        averaging.finish(is_bias_measured);
        let before = *averaging.result();
        let mut by = [0.0; GLOBALS];
        by[BIAS.from] = 0.2;
        averaging.inflate(&by, &mut Box::new(Update::<f64>::zero()).rows);
        let after = averaging.result();
        assert_eq!(after.mean, before.mean);
        let grown = after.covariance[triangle(NINE) + NINE] - before.covariance[triangle(NINE) + NINE];
        assert!((grown - 0.04).abs() < 1e-12, "{grown}");
    }
}

/// P and b follow an effect that is at another value as in the joint Gaussian of all globals whose other sensors'
/// errors have the widths that were chosen.
#[test]
fn what_is_not_known_of_an_effect_spreads_at_the_chosen_widths() {
    let grid = Widths { count: [1; GROUPS], ..Widths::HAND };
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(7);
    let mut uniform = || 2.0 * f64::from(generator.next_u32()) / f64::from(u32::MAX) - 1.0;
    let mut globals = Globals::<f64>::zero();
    globals.start();
    let root = SMatrix::<f64, GLOBALS, GLOBALS>::from_fn(|i, j| if i == j { 3.0 } else { uniform() });
    // With the priors inside.
    let information = root.transpose() * root + SMatrix::identity();
    let upper = information.cholesky().unwrap().l().transpose();
    for (i, row) in globals.root.iter_mut().enumerate() {
        row[..WIDE - 1].copy_from_slice(upper.row(i).transpose().as_slice());
    }
    let pull = SVector::<f64, GLOBALS>::from_fn(|_, _| uniform());
    let wide = information.try_inverse().unwrap() * pull;
    // All widths but those of the lags and of the accelerometer's bias are narrower.
    let narrow = information
        + SMatrix::from_diagonal(&SVector::<f64, GLOBALS>::from_fn(|c, _| {
            let variable = (0..VARIABLES).find(|variable| column(*variable) == c).unwrap();
            let mut group = None;
            for (place, of) in TAKEN.into_iter().enumerate() {
                let from = LEFT_AFTER[place];
                let is_lag = HAS_LAG[of] && variable + 1 == from + COUNTS[of];
                if (from..from + COUNTS[of]).contains(&variable) && !is_lag {
                    group = Some(of);
                }
            }
            group.map_or(0.0, |of| 1.0 / f64::from(grid.parts[of][0]).powi(2) - 1.0)
        }));
    let expected = narrow.try_inverse().unwrap() * pull;
    let mut update = Box::new(Update::<f64>::zero());
    let mut averaging = Averaging::<f64>::zero();
    averaging.start(&globals, &grid, &mut update.rows);
    averaging.gather(0..GLOBALS, &mut update.rows);
    while averaging.step(&mut update.rows) {}
    averaging.finish(true);
    let before = *averaging.result();
    averaging.inflate(&wide.into(), &mut update.rows);
    let after = averaging.result();
    let at = |k: usize| if k < NINE { P.from + k } else { BIAS.from + k - NINE };
    let mut moved = 0.0_f64;
    for i in 0..GYRO {
        for j in 0..=i {
            let grown = after.covariance[triangle(i) + j] - before.covariance[triangle(i) + j];
            assert!((grown - expected[at(i)] * expected[at(j)]).abs() < 1e-9, "{i} {j}: {grown}");
        }
        moved = moved.max((expected[at(i)] - wide[at(i)]).abs());
    }
    assert!(moved > 0.01, "{moved}");
}
