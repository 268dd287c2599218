#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::correlate::Memory;
use crate::diagnosis::stream::UNDER_WAY;
use nalgebra::Vector3;

/// Farthest test windows that are compared, in hops: six seconds, half a period of what comes back every twelve.
const FARTHEST: usize = 12;

/// Distances: from the first at which test windows do not overlap.
const DISTANCES: usize = FARTHEST - UNDER_WAY + 1;

/// Sum of the squared correlations of test windows that overlap, over all distances, which the variance of a sum of products of white
/// noise is larger by (Bartlett, Journal of the Royal Statistical Society Supplement 8 (1946) 27): of sin^2 weights every quarter of
/// their length, 1 + 2 (0.659^2 + 0.167^2 + 0.0075^2).
const OVERLAP: f32 = 1.92;

/// Fewest pairs at a distance: with fewer the sum of their products is not about normal.
const LEAST_PAIRS: f32 = 24.0;

/// No test window.
const NONE: u8 = u8::MAX;

/// Products of residuals some test windows apart.
pub(super) struct Whiteness {
    latest: [Vector3<f32>; FARTHEST],
    /// Which test windows they are of.
    numbers: [u8; FARTHEST],
    products: [f32; DISTANCES],
    pairs: [u8; DISTANCES],
}

impl Whiteness {
    #[inline(always)]
    pub const fn zero() -> Self {
        Self {
            latest: [Vector3::new(0.0, 0.0, 0.0); FARTHEST],
            numbers: [0; FARTHEST],
            products: [0.0; DISTANCES],
            pairs: [0; DISTANCES],
        }
    }

    pub fn start(&mut self) {
        *self = Self { numbers: [NONE; FARTHEST], ..Self::zero() };
    }

    /// Takes the residual of test window `number`, of which there are fewer than 255.
    #[inline(never)]
    pub fn add(&mut self, number: usize, residual: &Vector3<f32>) {
        for (step, (sum, pairs)) in self.products.iter_mut().zip(&mut self.pairs).enumerate() {
            let Some(earlier) = number.checked_sub(UNDER_WAY + step) else { break };
            if usize::from(self.numbers[earlier % FARTHEST]) == earlier {
                *sum += self.latest[earlier % FARTHEST].dot(residual);
                *pairs = pairs.saturating_add(1);
            }
        }
        self.latest[number % FARTHEST] = *residual;
        self.numbers[number % FARTHEST] = number as u8;
    }

    /// The distance at which the remainder is most like itself, or its opposite; p-value shared out among the distances (Bonferroni).
    #[inline(never)]
    pub fn memory(&self, mean: &Vector3<f32>, (variance, components): (f32, f32), hop_s: f32) -> Memory {
        let mut most = (0.0, Memory { p_value: 1.0, ..Memory::default() });
        if variance <= 0.0 {
            return most.1;
        }
        for (step, (sum, pairs)) in self.products.iter().zip(&self.pairs).enumerate() {
            let pairs = f32::from(*pairs);
            if pairs < LEAST_PAIRS {
                continue;
            }
            let correlation = (sum / pairs - mean.norm_squared()) / variance;
            let deviates = libm::fabsf(correlation) * libm::sqrtf(components * pairs / OVERLAP);
            if deviates > most.0 {
                let chance = DISTANCES as f32 * libm::erfcf(deviates * core::f32::consts::FRAC_1_SQRT_2);
                let apart_s = (UNDER_WAY + step) as f32 * hop_s;
                most = (deviates, Memory { correlation, apart_s, p_value: if chance < 1.0 { chance } else { 1.0 } });
            }
        }
        most.1
    }
}
