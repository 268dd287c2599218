#![allow(clippy::indexing_slicing)] // Constant indices into rows.

use super::BiasStep;
use crate::{
    diagnosis::weak_columns::{COLUMNS, GYRO},
    rotation::sine_and_cosine,
};
use nalgebra::{Matrix3, Vector3};

/// Scores of one test window, and information of two of them.
const SCORE: usize = 3;
const INFORMATION: usize = 6;

/// What the test windows say of a constant error of the rate, in memory that is lent.
pub(in crate::diagnosis) struct RateErrors<'a> {
    sums: &'a mut [f32],
}

/// When the test windows are.
#[derive(Clone, Copy)]
pub(in crate::diagnosis) struct Timing {
    /// First increment of the first.
    pub from: u32,
    pub hop: u32,
    /// Hops in a test window.
    pub hops: u32,
    /// How many there are.
    pub tests: u32,
}

impl Timing {
    /// Which share of a test window's weight lies before an increment: that of sin^2.
    #[inline(never)]
    pub(super) fn share(&self, test: u32, until: u32) -> f32 {
        let begin = self.from + test * self.hop;
        let length = self.hop * self.hops;
        if until <= begin {
            0.0
        } else if until >= begin + length {
            1.0
        } else {
            let part = (until - begin) as f32 / length as f32;
            part - sine_and_cosine(core::f32::consts::TAU * part).0 / core::f32::consts::TAU
        }
    }
}

impl<'a> RateErrors<'a> {
    /// In memory of at least 6 numbers per test window.
    pub fn new(sums: &'a mut [f32]) -> Self {
        Self { sums }
    }

    pub fn clear(&mut self) {
        self.sums.fill(0.0);
    }

    /// Adds the rows of one vector over one test window.
    #[inline(never)]
    pub fn add(&mut self, test: usize, rows: &[[f32; COLUMNS]; 3], residual: &[f32; 3], weight: f32) {
        let stride = 2 * SCORE + INFORMATION;
        let pair = self.sums.get_mut(test / 2 * stride..(test / 2 + 1) * stride).unwrap_or_default();
        let Some((scores, information)) = pair.split_at_mut_checked(2 * SCORE) else { return };
        for (row, r) in rows.iter().zip(residual) {
            let [x, y, z] = [row[GYRO - 3], row[GYRO - 2], row[GYRO - 1]];
            let scores = scores.iter_mut().skip(test % 2 * SCORE);
            scores.zip([x, y, z]).for_each(|(sum, a)| *sum += weight * a * r);
            let products = [x * x, y * x, y * y, z * x, z * y, z * z];
            information.iter_mut().zip(products).for_each(|(sum, product)| *sum += weight * product);
        }
    }

    /// Score and information of a test window; the information is the mean of two.
    #[inline(never)]
    pub(super) fn of(&self, test: u32) -> (Vector3<f32>, Matrix3<f32>) {
        let stride = 2 * SCORE + INFORMATION;
        let pair = (test / 2) as usize * stride;
        let Some([a, b, c, d, e, f, xx, yx, yy, zx, zy, zz]) =
            self.sums.get(pair..).and_then(|sums| sums.first_chunk::<12>())
        else {
            return (Vector3::zeros(), Matrix3::zeros());
        };
        let score = if test.is_multiple_of(2) { Vector3::new(*a, *b, *c) } else { Vector3::new(*d, *e, *f) };
        (score, Matrix3::new(*xx, *yx, *zx, *yx, *yy, *zy, *zx, *zy, *zz) * 0.5)
    }

    /// Puts a step that has been taken out back into the scores. `unit`: rate per unit of c's columns, rad/s.
    #[inline(never)]
    pub(super) fn put_back(&mut self, step: &BiasStep, timing: &Timing, unit_rad_s: f32) {
        let x = step.step_rad_s / -unit_rad_s;
        for test in 0..timing.tests {
            let share = timing.share(test, step.until);
            if share == 0.0 {
                break;
            }
            let (_, information) = self.of(test);
            let added = information * x * share;
            let stride = 2 * SCORE + INFORMATION;
            let at = (test / 2) as usize * stride + (test % 2) as usize * SCORE;
            self.sums.iter_mut().skip(at).zip(added.iter()).for_each(|(sum, added)| *sum += added);
        }
    }
}
