//! The globals as the matrices and vectors that they stand for.

#![allow(clippy::indexing_slicing)] // Constant indices of the table.

use super::{
    columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, BIAS, GLOBALS, HARD_IRON, MAG_LAG, MAG_MATRIX},
    real::{M3, Real, V3, identity, zero3, zero33},
};
use nalgebra::Matrix3;

/// 1 / sqrt 2.
const HALF_ROOT: f32 = core::f32::consts::FRAC_1_SQRT_2;
/// 1 / sqrt 6.
const SIXTH_ROOT: f32 = 0.408_248_3;

/// Sensor errors at which a node's rows are made linear: constant over the node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<T> {
    /// I + magnetometer matrix.
    pub mag_matrix: M3<T>,
    /// Added to the field that was read, in units of the field's norm.
    pub hard_iron: V3<T>,
    /// Delay of the magnetometer behind the gyro, seconds.
    pub mag_lag: T,
    /// Delay of the accelerometer behind the gyro, seconds.
    pub accel_lag: T,
    /// I + accelerometer matrix.
    pub accel_matrix: M3<T>,
    /// Added to the specific force that was read, m/s^2.
    pub accel_bias: V3<T>,
    /// Gyro bias, rad/s, raw frame.
    pub bias: V3<T>,
    /// Gyro matrix P.
    pub p: M3<T>,
}

impl<T: Real> Parameters<T> {
    pub(super) const fn zero() -> Self {
        Self {
            mag_matrix: zero33(),
            hard_iron: zero3(),
            mag_lag: T::ZERO,
            accel_lag: T::ZERO,
            accel_matrix: zero33(),
            accel_bias: zero3(),
            bias: zero3(),
            p: zero33(),
        }
    }

    /// Inverse of P; the identity if it has none.
    pub(super) fn inverse(&self) -> M3<T> {
        self.p.try_inverse().unwrap_or_else(identity)
    }

    /// Raw rate that P makes this compensated rate of, beside the bias.
    pub(super) fn turned_back(&self, rate: &V3<T>) -> V3<T> {
        self.inverse() * rate
    }

    /// Parameters from the globals' deviations from the prior's mean, in their own units, that mean of the bias, and P.
    pub(super) fn new(x: &[T; GLOBALS], bias: &V3<T>, p: M3<T>) -> Self {
        let m = &x[MAG_MATRIX.columns()];
        let h = T::of(HALF_ROOT);
        let (u, v) = (m[0] * h, m[1] * T::of(SIXTH_ROOT));
        let mag = Matrix3::new(
            u + v,
            (m[2] + m[5]) * h,
            (m[3] + m[6]) * h,
            (m[2] - m[5]) * h,
            v - u,
            (m[4] + m[7]) * h,
            (m[3] - m[6]) * h,
            (m[4] - m[7]) * h,
            -(v + v),
        );
        let a = &x[ACCEL_MATRIX.columns()];
        let accel = Matrix3::new(
            a[0],
            (a[3] + a[6]) * h,
            (a[4] + a[7]) * h,
            (a[3] - a[6]) * h,
            a[1],
            (a[5] + a[8]) * h,
            (a[4] - a[7]) * h,
            (a[5] - a[8]) * h,
            a[2],
        );
        let three = |from: usize| V3::new(x[from], x[from + 1], x[from + 2]);
        Self {
            mag_matrix: identity::<T>() + mag,
            hard_iron: three(HARD_IRON.from),
            mag_lag: x[MAG_LAG.from],
            accel_lag: x[ACCEL_LAG.from],
            accel_matrix: identity::<T>() + accel,
            accel_bias: three(ACCEL_BIAS.from),
            bias: bias + three(BIAS.from),
            p,
        }
    }
}

/// Derivatives with respect to the nine elements of the magnetometer matrix (row-major) as those of its eight columns.
pub(super) fn mag_columns<T: Real>(elements: &[T; 9]) -> [T; 8] {
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *elements;
    let (h, two) = (T::of(HALF_ROOT), T::of(2.0));
    [
        (xx - yy) * h,
        (xx + yy - two * zz) * T::of(SIXTH_ROOT),
        (xy + yx) * h,
        (xz + zx) * h,
        (yz + zy) * h,
        (xy - yx) * h,
        (xz - zx) * h,
        (yz - zy) * h,
    ]
}

/// Derivatives by the nine elements of the accelerometer matrix (row-major) as those of its nine columns.
pub(super) fn accel_columns<T: Real>(elements: &[T; 9]) -> [T; 9] {
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *elements;
    let h = T::of(HALF_ROOT);
    [xx, yy, zz, (xy + yx) * h, (xz + zx) * h, (yz + zy) * h, (xy - yx) * h, (xz - zx) * h, (yz - zy) * h]
}

#[cfg(test)]
mod tests;
