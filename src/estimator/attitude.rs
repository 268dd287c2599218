//! The estimator's own attitude at a sample's time, with its covariance. P, bias and the errors of the vector sensors
//! are estimated beside it, so that no wrong gyro model has turned it.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    Estimator,
    columns::{FIELD, GLOBALS, NODE},
    filter::Filter,
    increment::Item,
    real::{Real, rotation},
};
use nalgebra::Matrix3;

/// Least square of the horizontal field over that of the whole: within 6 deg of a magnetic pole there is no heading.
const LEAST_LEVEL_SQUARE: f32 = 0.01;

/// Attitude of the body at one instant.
#[derive(Clone, Copy, Debug)]
pub struct KnownAttitude {
    /// Body to NED, counted from magnetic north.
    pub rotation: Matrix3<f32>,
    /// Covariance of its error, a rotation vector in NED, rad^2.
    pub covariance: Matrix3<f32>,
}

impl<T: Real, const NODES: usize, const E: usize> Estimator<T, NODES, E> {
    /// Asks for the attitude at the time of the last [`Estimator::push`], which must have returned true.
    pub fn look(&mut self) {
        self.known_attitude.clear();
        self.intake.ask(Item::Look);
    }

    /// Attitude for the latest call of [`Estimator::look`]; `None` until [`Estimator::step`] has worked up to that
    /// call, and if attitude or heading is unknown there.
    pub fn known_attitude(&self) -> Option<&KnownAttitude> {
        self.known_attitude.first()
    }
}

impl<T: Real, const NODES: usize, const E: usize> Filter<T, NODES, E> {
    /// Attitude at the end of the latest increment, even if that increment still waits for its successor; `None` if the
    /// attitude or its heading is unknown.
    pub(super) fn attitude(&self) -> Option<KnownAttitude> {
        let field = self.node.field;
        let level = field.x * field.x + field.y * field.y;
        let is_level = level > T::of(LEAST_LEVEL_SQUARE) * (level + field.z * field.z);
        let is_known = self.course.is_aligned && self.node.has_field && is_level;
        let held = self.course.neighbours.held().filter(|_| is_known)?;
        let (north, west) = (field.x / level.root(), field.y / level.root());
        // Rows: north, east and down in the node's own frame, whose z is up.
        let turn = Matrix3::new(north, west, T::ZERO, west, -north, T::ZERO, T::ZERO, T::ZERO, -T::ONE);
        let mut by = [[T::ZERO; NODE]; 3];
        for (axis, by) in by.iter_mut().enumerate() {
            for k in 0..3 {
                by[k] = turn[(axis, k)];
            }
        }
        // Heading is counted from the field.
        by[2][FIELD] = -field.y / level;
        by[2][FIELD + 1] = field.x / level;
        let solved = by.map(|by| self.solved(&by));
        let product = |i: usize, j: usize| {
            let (a, b): (&[T; NODE + GLOBALS], &[T; NODE + GLOBALS]) = (&solved[i], &solved[j]);
            a.iter().zip(b).fold(T::ZERO, |sum, (a, b)| sum + *a * *b)
        };
        let since = self.unknown_rotation();
        let covariance = Matrix3::from_fn(product) + Matrix3::from_diagonal_element(since);
        // A reading of an instant stands for the interval about it, so that an increment ends half a period after its
        // last sample.
        let late = if self.settings.is_instant { T::of(0.5 * self.settings.sample_period_s) } else { T::ZERO };
        let last = self.parameters.p * (held.rate - self.parameters.bias) * (held.seconds - late);
        let attitude = turn * self.node.attitude * self.pre.rotation * rotation(&last);
        Some(KnownAttitude { rotation: attitude.map(|x| x.narrow()), covariance: covariance.map(|x| x.narrow()) })
    }

    /// Returns R^-T d for the root R of node and globals and a combination d of the node's states, in which the
    /// square of the result is the variance of d x.
    fn solved(&self, by: &[T; NODE]) -> [T; NODE + GLOBALS] {
        let mut solved = [T::ZERO; NODE + GLOBALS];
        solved[..NODE].copy_from_slice(by);
        for i in 0..NODE {
            let row = &self.node.root[i];
            let y = solved[i] / row[i];
            solved[i] = y;
            for c in i + 1..NODE + GLOBALS {
                solved[c] -= row[c] * y;
            }
        }
        for i in 0..GLOBALS {
            let row = &self.globals.root[i];
            let y = solved[NODE + i] / row[i];
            solved[NODE + i] = y;
            for c in i + 1..GLOBALS {
                solved[NODE + c] -= row[c] * y;
            }
        }
        solved
    }
}
