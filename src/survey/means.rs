//! Means in single precision over many samples, without loss of precision: compensated sums of differences from the
//! first value.

use nalgebra::{Matrix3, Vector3};

/// Mean of the vectors of one block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockMean {
    origin: Vector3<f32>,
    sum: Vector3<f32>,
    /// Excess that rounding has put into the sum (Kahan, Comm. ACM 8(1), 1965).
    excess: Vector3<f32>,
    count: u32,
}

impl BlockMean {
    pub(crate) const fn new() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { origin: zero, sum: zero, excess: zero, count: 0 }
    }

    pub(crate) fn add(&mut self, v: &Vector3<f32>) {
        if self.count == 0 {
            self.origin = *v;
        }
        let part = v - self.origin - self.excess;
        let sum = self.sum + part;
        self.excess = (sum - self.sum) - part;
        self.sum = sum;
        self.count = self.count.saturating_add(1);
    }

    pub(crate) fn mean(&self) -> Option<Vector3<f32>> {
        (self.count > 0).then(|| self.origin + self.sum / self.count as f32)
    }
}

/// Mean of block means, with its covariance from their scatter, which is right also for noise that is correlated within
/// a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanOfBlocks {
    first: Vector3<f32>,
    sum: Vector3<f32>,
    squares: Matrix3<f32>,
    count: u16,
}

impl MeanOfBlocks {
    pub(crate) const fn new() -> Self {
        Self {
            first: Vector3::new(0.0, 0.0, 0.0),
            sum: Vector3::new(0.0, 0.0, 0.0),
            squares: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            count: 0,
        }
    }

    /// Mean of the first block; zero before the first block.
    pub(crate) const fn first(&self) -> &Vector3<f32> {
        &self.first
    }

    pub(crate) const fn count(&self) -> u16 {
        self.count
    }

    pub(crate) fn add(&mut self, block: &Vector3<f32>) {
        if self.count == 0 {
            self.first = *block;
        }
        let d = block - self.first;
        self.sum += d;
        self.squares += d * d.transpose();
        self.count = self.count.saturating_add(1);
    }

    pub(crate) fn mean(&self) -> Vector3<f32> {
        if self.count == 0 { self.first } else { self.first + self.sum / f32::from(self.count) }
    }

    /// Covariance of the mean, from the scatter of the blocks; zero for fewer than two.
    pub(crate) fn covariance(&self) -> Matrix3<f32> {
        if self.count < 2 {
            return Matrix3::zeros();
        }
        let n = f32::from(self.count);
        (self.squares - self.sum * self.sum.transpose() / n) / (n * (n - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    #[test]
    fn a_long_mean_of_a_large_vector_keeps_its_last_digits() {
        let mut mean = BlockMean::new();
        for k in 0..100_000_u32 {
            // Alternates about 9.8, the exact mean.
            mean.add(&Vector3::new(0.0, 0.0, if k % 2 == 0 { -9.75 } else { -9.85 }));
        }
        assert!((mean.mean().unwrap().z + 9.8).abs() < 2e-6, "{}", mean.mean().unwrap().z);
        assert!(BlockMean::new().mean().is_none());
    }

    #[test]
    fn the_covariance_is_that_of_the_mean_of_independent_blocks() {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut uniform = || (rng.next_u32() >> 8) as f32 / 16_777_216.0 - 0.5;
        let (mut stated, mut actual) = (0.0, 0.0);
        for _ in 0..2_000 {
            let mut means = MeanOfBlocks::new();
            (0..8).for_each(|_| means.add(&Vector3::new(uniform() + 50.0, 0.0, 0.0)));
            stated += means.covariance().m11;
            actual += (means.mean().x - 50.0) * (means.mean().x - 50.0);
        }
        assert!((stated / actual - 1.0).abs() < 0.1, "{stated} {actual}");
    }
}
