#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::correlation::REGRESSORS;
use crate::diagnosis::{stream::UNDER_WAY, walk::Instant};
use core::f32::consts::FRAC_1_PI;

/// Facts of an instant.
const FACTS: usize = 16;

/// Of the facts, where the rate in the frame of the walk's beginning stands.
const TURNING: usize = 13;

/// Every other increment is looked at: three revolutions in a second are still seen six times each, or more.
const STRIDE: u16 = 2;

/// A quarter of sin^2 over a test window, at its ends and in its middle: the weights of a mean over it.
const WEIGHTS: [f32; UNDER_WAY] =
    [0.25 - 0.5 * FRAC_1_PI, 0.25 + 0.5 * FRAC_1_PI, 0.25 + 0.5 * FRAC_1_PI, 0.25 - 0.5 * FRAC_1_PI];

/// The same of its slope, which has the sign of the half: the mean of a derivative, up to a factor.
const SLOPES: [f32; UNDER_WAY] = [-1.0, -1.0, 1.0, 1.0];

/// The conditions that test windows are under: sums over the last four hops, which make up a window.
pub(super) struct Conditions {
    hops: [[f32; FACTS]; UNDER_WAY],
    /// The hop in progress, and increments in it.
    current: u8,
    increments: u16,
    length: u16,
}

impl Conditions {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self { hops: [[0.0; FACTS]; UNDER_WAY], current: 0, increments: 0, length: 0 }
    }

    /// Begins with the first test window, whose hops have `length` increments.
    pub fn start(&mut self, length: usize) {
        *self = Self { length: length as u16, ..Self::zero() };
    }

    /// Takes the next instant.
    #[inline(never)]
    pub fn take(&mut self, instant: &Instant) {
        if self.increments >= self.length {
            self.current = (self.current + 1) % UNDER_WAY as u8;
            self.increments = 0;
            if let Some(hop) = self.hops.get_mut(usize::from(self.current)) {
                *hop = [0.0; FACTS];
            }
        }
        let is_looked_at = self.increments.is_multiple_of(STRIDE);
        self.increments += 1;
        if !is_looked_at {
            return;
        }
        let moment = &instant.moment;
        let (w, f) = (&moment.rate_rad_s, &moment.force_m_s2);
        let across = libm::sqrtf(f.x * f.x + f.y * f.y);
        let (cosine, sine) = if across > 0.0 { (f.x / across, f.y / across) } else { (0.0, 0.0) };
        let turning = instant.rotation * w;
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
        let hop = self.hops.get_mut(usize::from(self.current));
        hop.into_iter().flatten().zip(&facts).for_each(|(sum, fact)| *sum += fact);
    }

    /// The regressors of the test window that has just been completed, the `number`th.
    #[inline(never)]
    pub fn of_window(&self, number: usize) -> [f32; REGRESSORS] {
        let mut facts = [0.0; FACTS];
        for (age, (weight, slope)) in WEIGHTS.iter().zip(SLOPES).enumerate() {
            let hop = &self.hops[(usize::from(self.current) + 1 + age) % UNDER_WAY];
            for (at, (sum, fact)) in facts.iter_mut().zip(hop).enumerate() {
                *sum += if at < TURNING { weight } else { &slope } * fact;
            }
        }
        let mut regressors = [0.0; REGRESSORS];
        // Of the order of 1, and about zero: so that it and its square are not much the same.
        let time = number as f32 / 32.0 - 1.0;
        regressors[0] = time;
        regressors[1] = time * time;
        regressors.iter_mut().skip(2).zip(&facts).for_each(|(x, fact)| *x = *fact);
        regressors
    }
}
