#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::robust_loss::{huber, huber_weight};
use crate::{
    algebra::Packed,
    identification::Prior,
    optimizer::{Cost, LeastSquaresCost},
    rotation::rotate_by_minus,
    window::{Segment, Sighting},
};
use nalgebra::Vector3;

/// Standard deviations of one component of a segment's vector residual (unit vectors), at rest and in motion: one for both
/// would let the quiet seconds shout down the ones that turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NoiseScales {
    /// Gravity: [rest, moving].
    pub gravity: [f32; 2],
    /// Field: [rest, moving].
    pub field: [f32; 2],
}

impl NoiseScales {
    pub const fn zero() -> Self {
        Self { gravity: [0.0; 2], field: [0.0; 2] }
    }
}

/// Objective of the search: over the segments, the robust squared distance between the gravity and field vectors carried by
/// the candidate's rotation and those measured (the angle of the paper's eq 5, over segments instead of dead reckoning and with
/// the field beside gravity), plus the prior.
///
/// The unknown is delta = theta - theta0, theta0 being where the segments were pre-integrated.
pub(crate) struct TwoVector<'a> {
    pub segments: &'a [Segment],
    pub scales: &'a NoiseScales,
    pub prior: &'a Prior,
    pub theta0: &'a [f32; 12],
}

impl TwoVector<'_> {
    /// Calls `f` with each sighting of a segment and its inverse variance.
    fn sightings(&self, segment: &Segment, mut f: impl FnMut(&Sighting, f32)) {
        let class = usize::from(segment.moving);
        let inverse = |sigma: f32| if sigma > 0.0 { 1.0 / (sigma * sigma) } else { 0.0 };
        if let Some(sighting) = &segment.gravity {
            f(sighting, inverse(self.scales.gravity[class]));
        }
        if let Some(sighting) = &segment.field {
            f(sighting, inverse(self.scales.field[class]));
        }
    }
}

/// Rotation vector J delta of a segment.
pub(crate) fn turn(segment: &Segment, delta: &[f32; 12]) -> Vector3<f32> {
    let mut phi = [0.0; 3];
    for (sum, row) in phi.iter_mut().zip(&segment.jacobian) {
        for (j, d) in row.iter().zip(delta) {
            *sum += j * d;
        }
    }
    Vector3::from(phi)
}

/// Measured minus predicted vector of a sighting, the rotation changed by `phi`.
pub(crate) fn residual(sighting: &Sighting, phi: &Vector3<f32>) -> Vector3<f32> {
    sighting.measured - rotate_by_minus(phi, &sighting.predicted)
}

impl Cost<12> for TwoVector<'_> {
    fn evaluate(&self, delta: &[f32; 12]) -> f32 {
        let mut cost = self.prior.cost(self.theta0, delta);
        for segment in self.segments {
            let phi = turn(segment, delta);
            self.sightings(segment, |sighting, weight| {
                cost += huber(residual(sighting, &phi).norm_squared() * weight);
            });
        }
        cost
    }
}

impl LeastSquaresCost<12, 78> for TwoVector<'_> {
    fn normal_equations(&self, delta: &[f32; 12], normal: &mut Packed<12, 78>, descent: &mut [f32; 12]) {
        *normal = self.prior.information;
        *descent = self.prior.descent(self.theta0, delta);
        for segment in self.segments {
            let phi = turn(segment, delta);
            self.sightings(segment, |sighting, weight| {
                let carried = rotate_by_minus(&phi, &sighting.predicted);
                let r = sighting.measured - carried;
                let w = weight * huber_weight(r.norm_squared() * weight);
                // d(carried)/d(phi) = [carried]x, so the rows are [carried]x J.
                for axis in 0..3 {
                    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut row = [0.0; 12];
                    for (k, value) in row.iter_mut().enumerate() {
                        *value = carried[b] * segment.jacobian[c][k] - carried[c] * segment.jacobian[b][k];
                    }
                    normal.add_outer(&row, w);
                    for (d, value) in descent.iter_mut().zip(&row) {
                        *d += w * value * r[axis];
                    }
                }
            });
        }
    }
}
