//! Gyro model: P and b, the twelve parameters that are identified (paper, eq 1 to 4).

use crate::{algebra::are_finite, sample::BEYOND_ANY_GYRO_RAD_S};
use nalgebra::{Matrix3, Vector3};

/// One number for each parameter of a gyro model: P row by row, dimensionless, then b, rad/s.
pub type Theta = [f32; 12];

/// Gyro model, 12 error parameters: `w = P (w_raw - b)` (paper, eq 1 to 4; P = (I + S)^-1).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GyroModel {
    /// Matrix P, row-major, dimensionless: inverse of scale factors and cross-couplings; the identity for a
    /// perfect gyro.
    pub p: [[f32; 3]; 3],
    /// Bias b, rad/s: the zero-rate output in the raw frame, subtracted before P.
    pub b_rad_s: [f32; 3],
}

impl GyroModel {
    /// Identity model: the raw reading passes through.
    pub const IDENTITY: Self = Self { p: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], b_rad_s: [0.0; 3] };

    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self { p: [[0.0; 3]; 3], b_rad_s: [0.0; 3] };

    /// Compensates a raw reading, rad/s, to the body rate, rad/s.
    #[must_use]
    pub fn compensate(&self, raw_rad_s: [f32; 3]) -> Vector3<f32> {
        self.p_matrix() * (Vector3::from(raw_rad_s) - Vector3::from(self.b_rad_s))
    }

    /// P as a matrix.
    #[must_use]
    pub fn p_matrix(&self) -> Matrix3<f32> {
        let [r0, r1, r2] = self.p;
        Matrix3::new(r0[0], r0[1], r0[2], r1[0], r1[1], r1[2], r2[0], r2[1], r2[2])
    }

    /// Returns true if every parameter is finite, P has a positive determinant, and no reading becomes a rate whose
    /// square an f32 does not hold: elements of P and of P b below 1,000.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let finite = are_finite(self.p.as_flattened()) && are_finite(&self.b_rad_s);
        let determinant = self.p_matrix().determinant();
        let of_none = self.compensate([0.0; 3]);
        let mut bounded = self.p.iter().flatten().chain(of_none.iter());
        finite
            && determinant.is_finite()
            && determinant > 0.0
            && bounded.all(|x| libm::fabsf(*x) < BEYOND_ANY_GYRO_RAD_S)
    }
}

impl Default for GyroModel {
    fn default() -> Self {
        Self::IDENTITY
    }
}

#[cfg(test)]
mod tests;
