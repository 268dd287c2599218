//! Whitening of vectors by a covariance.

#![allow(clippy::indexing_slicing)] // Constant indices into a 3x3 matrix.

use nalgebra::{Matrix3, Vector3};

/// Inverse Cholesky factor L^-1 of a covariance S = L L^T: it whitens vectors to unit covariance. (nalgebra's
/// solver keeps a panic reachable for the compiler.)
#[derive(Clone, Copy)]
pub(crate) struct Whitening {
    /// Inverses of L's diagonal.
    inverse: Vector3<f32>,
    /// Elements (1, 0), (2, 0) and (2, 1) of L.
    below: Vector3<f32>,
}

impl Whitening {
    /// Factorises a covariance; `None` if it is not positive definite.
    pub fn new(s: &Matrix3<f32>) -> Option<Self> {
        let root = |square: f32| (square > 0.0 && square.is_finite()).then(|| 1.0 / libm::sqrtf(square));
        let first = root(s[(0, 0)])?;
        let (l10, l20) = (s[(1, 0)] * first, s[(2, 0)] * first);
        let second = root(s[(1, 1)] - l10 * l10)?;
        let l21 = (s[(2, 1)] - l20 * l10) * second;
        let third = root(s[(2, 2)] - l20 * l20 - l21 * l21)?;
        Some(Self { inverse: Vector3::new(first, second, third), below: Vector3::new(l10, l20, l21) })
    }

    /// Returns L^-1 v.
    pub fn apply(&self, v: &Vector3<f32>) -> Vector3<f32> {
        let x = v.x * self.inverse.x;
        let y = (v.y - self.below.x * x) * self.inverse.y;
        let z = (v.z - self.below.y * x - self.below.z * y) * self.inverse.z;
        Vector3::new(x, y, z)
    }

    /// Natural logarithm of the covariance's determinant.
    pub fn log_determinant(&self) -> f32 {
        -2.0 * libm::logf(self.inverse.x * self.inverse.y * self.inverse.z)
    }
}

#[cfg(test)]
mod tests;
