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
mod tests;
