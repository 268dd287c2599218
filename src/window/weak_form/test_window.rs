#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::super::{
    equations::TestEquations,
    rows::{GYRO, MAGNETIC, Rows},
};
use nalgebra::{Matrix3, Vector3};

/// Gravity at an increment: de-rotated, and what the gyro's error does to it, R0 [v]x.
pub(super) struct Gravity {
    pub u: Vector3<f32>,
    pub gain: Matrix3<f32>,
}

/// The field at an increment: de-rotated, what the gyro's error does to it, R0 [v]x, what a lag does, R0 (w x v), and its squared second
/// difference.
pub(super) struct Field {
    pub u: Vector3<f32>,
    pub gain: Matrix3<f32>,
    pub lag: Vector3<f32>,
    pub roughness: f32,
}

/// Accumulators of one test window.
#[derive(Clone, Copy, Debug)]
pub(super) struct TestWindow {
    /// Increments taken; before the first one it may be at a wrapped position that counts up to 0.
    pub position: usize,
    gravity_rows: [[f32; GYRO]; 3],
    gravity_rhs: Vector3<f32>,
    field_rows: [[f32; MAGNETIC]; 3],
    field_rhs: Vector3<f32>,
    square_rate: f32,
    /// Sum of the squared second differences of the de-rotated field.
    square_roughness: f32,
    pub spoilt: bool,
    gravity_missing: bool,
    field_missing: bool,
}

impl TestWindow {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            position: 0,
            gravity_rows: [[0.0; GYRO]; 3],
            gravity_rhs: zero,
            field_rows: [[0.0; MAGNETIC]; 3],
            field_rhs: zero,
            square_rate: 0.0,
            square_roughness: 0.0,
            spoilt: false,
            gravity_missing: false,
            field_missing: false,
        }
    }

    /// Takes an increment's rates: the raw one, `None` where it was not read, and the nominal one.
    pub fn add_rate(&mut self, raw: Option<&Vector3<f32>>, rate: &Vector3<f32>) {
        self.spoilt |= raw.is_none();
        self.square_rate += rate.norm_squared();
    }

    /// Takes the gravity of an increment with the test function's weight and slope.
    pub fn add_gravity(&mut self, gravity: Option<&Gravity>, raw: &Vector3<f32>, (weight, slope): (f32, f32)) {
        let Some(Gravity { u, gain }) = gravity else {
            self.gravity_missing = true;
            return;
        };
        self.gravity_rhs += u * slope;
        for i in 0..3 {
            add_gyro_row(&mut self.gravity_rows[i], gain, i, raw, weight);
        }
    }

    /// Takes the field of an increment, de-rotated by `rotation`.
    pub fn add_field(
        &mut self,
        field: Option<&Field>,
        rotation: &Matrix3<f32>,
        raw: &Vector3<f32>,
        (weight, slope): (f32, f32),
    ) {
        let Some(Field { u, gain, lag, roughness }) = field else {
            self.field_missing = true;
            return;
        };
        self.square_roughness += roughness;
        self.field_rhs += u * slope;
        for i in 0..3 {
            let row = &mut self.field_rows[i];
            add_gyro_row(row, gain, i, raw, weight);
            row[GYRO] += slope * lag[i];
            for j in 0..3 {
                row[GYRO + 1 + j] += slope * rotation[(i, j)];
            }
        }
    }

    /// The equations, about `theta`, none when the tool stood still or readings were missing; begins anew.
    pub fn complete(&mut self, moving_rate_rad_s: f32, theta: &[f32; GYRO]) -> TestEquations {
        let limit = moving_rate_rad_s * moving_rate_rad_s * self.position as f32;
        let counts = !self.spoilt && self.square_rate > limit;
        let mut equations = TestEquations { spoilt: self.spoilt, ..TestEquations::zero() };
        if counts && !self.gravity_missing {
            equations.gravity = Rows::new(&self.gravity_rows, &self.gravity_rhs.into(), theta);
        }
        if counts && !self.field_missing {
            // Three components, and 1 + 4 + 1 variances in a second difference.
            equations.field_noise_ut2 = self.square_roughness / (18.0 * self.position as f32);
            equations.field = Rows::new(&self.field_rows, &self.field_rhs.into(), theta);
        }
        *self = Self::zero();
        equations
    }
}

/// Adds `weight * gain_row (x) (raw, -1)` to the gyro's part of a row: d(dw)/d(P, c) seen through R0 [v]x.
fn add_gyro_row<const D: usize>(row: &mut [f32; D], gain: &Matrix3<f32>, i: usize, raw: &Vector3<f32>, weight: f32) {
    for j in 0..3 {
        let g = gain[(i, j)] * weight;
        row[3 * j] += g * raw.x;
        row[3 * j + 1] += g * raw.y;
        row[3 * j + 2] += g * raw.z;
        row[9 + j] -= g;
    }
}
