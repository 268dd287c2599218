//! Conditions of a node, with which its innovation may go.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::correlation::REGRESSORS;
use crate::compensation::Snapshot;
use nalgebra::Matrix3;

/// Number of conditions of an instant.
const FACTS: usize = 16;

/// Half of a window, seconds.
const HALF_S: f32 = 25.0;

/// The conditions that a node was under: means over its increments.
pub(super) struct Conditions {
    sums: [f32; FACTS],
    increments: u16,
}

impl Conditions {
    pub const fn zero() -> Self {
        Self { sums: [0.0; FACTS], increments: 0 }
    }

    /// Begins a node.
    pub fn start(&mut self) {
        *self = Self::zero();
    }

    /// Takes an increment, turned by `rotation` into the frame of the earth.
    #[inline(never)]
    pub fn take(&mut self, moment: &Snapshot, rotation: &Matrix3<f32>) {
        self.increments = self.increments.saturating_add(1);
        let (w, f) = (&moment.rate_rad_s, &moment.force_m_s2);
        let across = libm::sqrtf(f.x * f.x + f.y * f.y);
        let (cosine, sine) = if across > 0.0 { (f.x / across, f.y / across) } else { (0.0, 0.0) };
        let turning = rotation * moment.acceleration_rad_s2;
        let facts = [
            moment.warming_k,
            w.x,
            w.y,
            w.z,
            w.norm_squared(),
            f.x,
            f.y,
            f.z,
            moment.square_force_m2_s4,
            cosine,
            sine,
            cosine * cosine - sine * sine,
            2.0 * cosine * sine,
            turning.x,
            turning.y,
            turning.z,
        ];
        self.sums.iter_mut().zip(&facts).for_each(|(sum, fact)| *sum += fact);
    }

    /// Regressors of the node, which begins so many seconds after the first node.
    pub fn of_node(&self, seconds: f32) -> [f32; REGRESSORS] {
        let mut regressors = [0.0; REGRESSORS];
        // Time is scaled to the order of 1 and about zero, so that it and its square differ.
        let time = seconds / HALF_S - 1.0;
        regressors[0] = time;
        regressors[1] = time * time;
        let share = 1.0 / f32::from(if self.increments > 0 { self.increments } else { 1 });
        regressors.iter_mut().skip(2).zip(&self.sums).for_each(|(x, sum)| *x = *sum * share);
        regressors
    }
}
