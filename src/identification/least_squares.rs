#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::Prior;
use crate::{
    algebra::Packed,
    window::{Block, MAGNETIC},
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
    /// Nothing of the gyro.
    Nothing,
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

/// Solution of the weak form's equations with the prior: changes of P (9) and c (3), lag (s), hard iron (microtesla, 3).
/// `None` when the normal matrix cannot be factorised.
pub(crate) fn solve(
    sum: &Block,
    variances: &RowVariances,
    prior: &Prior,
    theta: &[f32; 12],
    (freedom, magnetometer): (&Freedom, MagnetometerErrors),
) -> Option<[f32; MAGNETIC]> {
    let mut normal = Packed::<MAGNETIC, 136>::zero();
    let mut rhs = [0.0; MAGNETIC];
    for i in 0..12 {
        for j in 0..=i {
            let gravity = sum.gravity.normal.get(i, j) / variances.gravity;
            normal.add(i, j, prior.information.get(i, j) + gravity);
        }
        rhs[i] = sum.gravity.rhs[i] / variances.gravity;
    }
    for (r, d) in rhs.iter_mut().zip(&prior.descent(theta, &[0.0; 12])) {
        *r += d;
    }
    normal.add(12, 12, 1.0 / (LAG_SIGMA_S * LAG_SIGMA_S));
    for i in 13..MAGNETIC {
        normal.add(i, i, 1.0 / (IRON_SIGMA_UT * IRON_SIGMA_UT));
    }
    normal.add_scaled(&sum.magnetic.normal, 1.0 / variances.field);
    for (r, h) in rhs.iter_mut().zip(&sum.magnetic.rhs) {
        *r += h / variances.field;
    }
    for i in 0..MAGNETIC {
        let fixed = match (i, freedom, magnetometer) {
            (0..9, Freedom::Bias(change), _) => change.get(i).copied(),
            (0..12, Freedom::Nothing, _) => Some(0.0),
            (12, _, MagnetometerErrors::None) => Some(0.0),
            (13.., _, MagnetometerErrors::None | MagnetometerErrors::Lag) => Some(0.0),
            _ => None,
        };
        let Some(value) = fixed else { continue };
        for (j, r) in rhs.iter_mut().enumerate() {
            *r -= normal.get(i, j) * value;
        }
        normal.freeze(i);
        if let Some(r) = rhs.get_mut(i) {
            *r = value;
        }
    }
    let x = normal.cholesky()?.solve(&rhs);
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// The solution with the whole gyro free and the row variances that its own misfit shows, iterated to agreement. `None`
/// without equations or when they cannot be solved.
pub(crate) fn solve_with_variances(
    sum: &Block,
    prior: &Prior,
    theta: &[f32; 12],
    magnetometer: MagnetometerErrors,
) -> Option<([f32; MAGNETIC], RowVariances)> {
    if sum.is_empty() {
        return None;
    }
    let variance = |misfit: f32, rows: u32| {
        // No rows: the variance divides zeros. An exact fit (synthetic data) keeps f32's own noise.
        let v = if rows == 0 { 1.0 } else { misfit / rows as f32 };
        if v > 1e-10 { v } else { 1e-10 }
    };
    let mut variances = RowVariances {
        gravity: variance(sum.gravity.square, sum.gravity.rows),
        field: variance(sum.magnetic.square, sum.magnetic.rows),
    };
    let mut x = solve(sum, &variances, prior, theta, (&Freedom::Full, magnetometer))?;
    // Converges by about a digit a round.
    for _ in 0..4 {
        variances = RowVariances {
            gravity: variance(sum.gravity.misfit(&gyro_part(&x)), sum.gravity.rows),
            field: variance(sum.magnetic.misfit(&x), sum.magnetic.rows),
        };
        x = solve(sum, &variances, prior, theta, (&Freedom::Full, magnetometer))?;
    }
    Some((x, variances))
}

/// Whitened misfit of a solution on a sum of equations: half the squared residuals over their variances.
pub(crate) fn misfit(sum: &Block, variances: &RowVariances, x: &[f32; MAGNETIC]) -> f32 {
    0.5 * (sum.gravity.misfit(&gyro_part(x)) / variances.gravity + sum.magnetic.misfit(x) / variances.field)
}

/// The first 12 unknowns.
pub(crate) fn gyro_part(x: &[f32; MAGNETIC]) -> [f32; 12] {
    core::array::from_fn(|i| x[i])
}
