#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::Prior;
use crate::{
    algebra::{Packed, add_scaled},
    window::{Equations, MAGNETIC, TestEquations, gyro_part},
};

/// Prior deviation of the magnetometer's lag behind the gyro, seconds: MEMS magnetometers take up to 10 ms a conversion and
/// hosts add as much; wide on purpose.
const LAG_SIGMA_S: f32 = 0.02;

/// Prior deviation of a hard iron, microtesla per axis: half of the earth's field; wide on purpose.
const IRON_SIGMA_UT: f32 = 25.0;

/// Variances of one row of the gravity and of the field equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RowVariances {
    pub gravity: f32,
    pub field: f32,
}

/// Which of the gyro's parameters a fit may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Freedom {
    /// P and c.
    Full,
    /// c; P changes by the given amount from the nominal model's (row-major).
    Bias([f32; 9]),
    /// Nothing: P and c change by the given amount.
    Held([f32; 12]),
}

/// Which errors of the magnetometer a fit may move; the others are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MagnetometerErrors {
    /// It is what it reads.
    None,
    /// Its lag behind the gyro.
    Lag,
    /// Its lag and a hard iron.
    LagAndIron,
}

/// What a fit may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Model {
    pub freedom: Freedom,
    pub magnetometer: MagnetometerErrors,
}

impl Model {
    /// P and c free.
    pub const fn full(magnetometer: MagnetometerErrors) -> Self {
        Self { freedom: Freedom::Full, magnetometer }
    }
}

/// What all fits of a window share.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub variances: &'a RowVariances,
    /// The factory's values and the bias from rest.
    pub base: &'a Prior,
    /// With what earlier windows taught; it counts where P is free. A P that is held where it was is held against it.
    pub prior: &'a Prior,
    /// The nominal model.
    pub theta: &'a [f32; 12],
}

/// The weak form's equations of both classes over their variances, with the prior of the magnetometer's errors: what all models of the same
/// test windows share.
pub(crate) struct NormalEquations {
    normal: Packed<MAGNETIC, 136>,
    rhs: [f32; MAGNETIC],
}

impl NormalEquations {
    pub fn new(sum: &Equations, variances: &RowVariances) -> Self {
        let mut normal = Packed::zero();
        let mut rhs = [0.0; MAGNETIC];
        normal.add_leading(&sum.gravity.normal, 1.0 / variances.gravity);
        add_scaled(&mut rhs, &sum.gravity.rhs, 1.0 / variances.gravity);
        normal.add(12, 12, 1.0 / (LAG_SIGMA_S * LAG_SIGMA_S));
        for i in 13..MAGNETIC {
            normal.add(i, i, 1.0 / (IRON_SIGMA_UT * IRON_SIGMA_UT));
        }
        normal.add_scaled(&sum.magnetic.normal, 1.0 / variances.field);
        add_scaled(&mut rhs, &sum.magnetic.rhs, 1.0 / variances.field);
        Self { normal, rhs }
    }

    /// The solution with the prior: changes of P (9) and c (3), lag (s), hard iron (microtesla, 3). `None` when the normal matrix cannot be
    /// factorised.
    pub fn solve(&self, known: &Known, model: &Model) -> Option<[f32; MAGNETIC]> {
        let Known { base, prior, theta, .. } = known;
        let Model { freedom, magnetometer } = model;
        let prior = if *freedom == Freedom::Full { prior } else { base };
        let (mut normal, mut rhs) = (self.normal, self.rhs);
        normal.add_leading(&prior.information, 1.0);
        add_scaled(&mut rhs, &prior.descent(theta, &[0.0; 12]), 1.0);
        let mut x = [0.0; MAGNETIC];
        let mut free = heapless::Vec::<usize, MAGNETIC>::new();
        for (i, x) in x.iter_mut().enumerate() {
            *x = match (i, freedom, magnetometer) {
                (0..9, Freedom::Bias(change), _) => change[i],
                (0..12, Freedom::Held(change), _) => change[i],
                (12, _, MagnetometerErrors::None) | (13.., _, MagnetometerErrors::None | MagnetometerErrors::Lag) => {
                    0.0
                }
                _ => {
                    // There is room for all.
                    let _ = free.push(i);
                    continue;
                }
            };
            if *x != 0.0 {
                for (j, r) in rhs.iter_mut().enumerate() {
                    *r -= normal.get(i, j) * *x;
                }
            }
        }
        let mut solution = [0.0; MAGNETIC];
        let part = solution.get_mut(..free.len())?;
        for (s, r) in part.iter_mut().zip(free.iter().filter_map(|i| rhs.get(*i))) {
            *s = *r;
        }
        normal.solve_part(&free, part)?;
        for (s, i) in part.iter().zip(&free) {
            *x.get_mut(*i)? = *s;
        }
        x.iter().all(|x| x.is_finite()).then_some(x)
    }
}

/// Rounds after which the solution and the row variances that its own misfit shows agree: by about a digit a round.
pub(crate) const ROUNDS: u8 = 5;

/// The solution with the whole gyro free and the row variances that `before`, the solution of the round before, leaves; those of no change
/// in the first. `None` without equations or when they cannot be solved.
pub(crate) fn solve_with_variances(
    sum: &Equations,
    prior: &Prior,
    theta: &[f32; 12],
    magnetometer: MagnetometerErrors,
    before: Option<&[f32; MAGNETIC]>,
) -> Option<([f32; MAGNETIC], RowVariances)> {
    if sum.is_empty() {
        return None;
    }
    let variance = |misfit: f32, rows: f32| {
        // No rows: the variance divides zeros. An exact fit (synthetic data) keeps f32's own noise.
        let v = if rows > 0.0 { misfit / rows } else { 1.0 };
        if v > 1e-10 { v } else { 1e-10 }
    };
    let misfits = before.map_or([sum.gravity.square, sum.magnetic.square], |x| {
        [sum.gravity.misfit(&gyro_part(x)), sum.magnetic.misfit(x)]
    });
    let variances = RowVariances {
        gravity: variance(misfits[0], sum.gravity.rows),
        field: variance(misfits[1], sum.magnetic.rows),
    };
    let known = Known { variances: &variances, base: prior, prior, theta };
    Some((NormalEquations::new(sum, &variances).solve(&known, &Model::full(magnetometer))?, variances))
}

/// Squared residuals of a test window over their variances, unweighted, at each of some solutions: gravity's and the field's.
pub(crate) fn test_misfits<const M: usize>(
    test: &TestEquations,
    known: &Known,
    xs: &[[f32; MAGNETIC]; M],
) -> [[f32; M]; 2] {
    let Known { variances, theta, .. } = known;
    let mut misfits = [[0.0; M]; 2];
    let [gravity, field] = &mut misfits;
    if test.gravity.is_some() {
        *gravity = test.gravity.misfits(theta, &xs.each_ref().map(gyro_part)).map(|square| square / variances.gravity);
    }
    if test.field.is_some() {
        *field = test.field.misfits(theta, xs).map(|square| square / variances.field);
    }
    misfits
}
