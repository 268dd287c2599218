//! An error of the rate before a time, by least squares.

use nalgebra::{Matrix3, Vector3};

/// Inverse of an information with the prior's, which is one.
#[inline(never)]
pub(super) fn inverse_with_prior(information: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    (information + Matrix3::identity()).try_inverse()
}

/// An error of the rate before a time, and one at all times.
#[derive(Clone, Copy)]
pub(super) struct Fit {
    pub step: Vector3<f32>,
    pub rest: Vector3<f32>,
    pub covariance: Matrix3<f32>,
}

/// Sums over test windows of their scores and information, each times its share, and of the information times the squared share.
#[derive(Clone, Copy)]
pub(super) struct Sums {
    pub score: Vector3<f32>,
    pub of_one: Matrix3<f32>,
    of_two: Matrix3<f32>,
}

impl Sums {
    pub const ZERO: Self = Self {
        score: Vector3::new(0.0, 0.0, 0.0),
        of_one: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        of_two: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    #[inline(never)]
    pub fn add(&mut self, score: &Vector3<f32>, information: &Matrix3<f32>, share: f32) {
        self.score += score * share;
        self.of_one += information * share;
        self.of_two += information * (share * share);
    }

    /// The error that goes with the share, beside one at all times, and twice its gain. The unit information of the prior keeps it
    /// solvable.
    #[inline(never)]
    pub fn fit(&self, all: &Self, inverse_of_all: &Matrix3<f32>) -> Option<(Fit, f32)> {
        let gains = self.of_one * inverse_of_all;
        let score = self.score - gains * all.score;
        let covariance = inverse_with_prior(&(self.of_two - gains * self.of_one))?;
        let step = covariance * score;
        let gain = step.dot(&score);
        let rest = inverse_of_all * (all.score - self.of_one * step);
        gain.is_finite().then_some((Fit { step, rest, covariance }, gain))
    }
}
