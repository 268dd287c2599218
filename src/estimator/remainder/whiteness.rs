//! Whiteness of the innovations: products of innovations some nodes apart, and their chance in white ones.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::correlate::Memory;
use nalgebra::Vector3;

/// Largest distance of compared nodes: 6 s at 0.5 s a node, half a period of a remainder that repeats every 12 s.
const FARTHEST: usize = 12;

/// Fewest pairs at a distance: with fewer the sum of their products is not about normal.
const LEAST_PAIRS: f32 = 24.0;

/// Products of innovations some nodes apart.
pub(super) struct Whiteness {
    latest: [Vector3<f32>; FARTHEST],
    products: [f32; FARTHEST],
    pairs: [u16; FARTHEST],
}

impl Whiteness {
    pub const fn zero() -> Self {
        Self { latest: [Vector3::new(0.0, 0.0, 0.0); FARTHEST], products: [0.0; FARTHEST], pairs: [0; FARTHEST] }
    }

    /// Takes the innovation of a node, by its number.
    #[inline(never)]
    pub fn add(&mut self, number: u16, innovation: &Vector3<f32>) {
        for (step, (sum, pairs)) in self.products.iter_mut().zip(&mut self.pairs).enumerate() {
            let Some(earlier) = usize::from(number).checked_sub(1 + step) else { break };
            *sum += self.latest[earlier % FARTHEST].dot(innovation);
            *pairs = pairs.saturating_add(1);
        }
        self.latest[usize::from(number) % FARTHEST] = *innovation;
    }

    /// Returns the distance at which the remainder is most like itself, or its opposite; its p-value is corrected for
    /// the number of distances (Bonferroni).
    #[inline(never)]
    pub fn memory(&self, mean: &Vector3<f32>, (variance, components): (f32, f32), node_s: f32) -> Memory {
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
            let deviates = libm::fabsf(correlation) * libm::sqrtf(components * pairs);
            if deviates > most.0 {
                let chance = FARTHEST as f32 * libm::erfcf(deviates * core::f32::consts::FRAC_1_SQRT_2);
                let apart_s = (1 + step) as f32 * node_s;
                most = (deviates, Memory { correlation, apart_s, p_value: if chance < 1.0 { chance } else { 1.0 } });
            }
        }
        most.1
    }
}
