//! Calibration of a vector sensor, from the factory or `cargo mwd calibrate`.

use crate::algebra::are_finite;
use nalgebra::{Matrix3, Vector3};

/// Calibration of a vector sensor (accelerometer or magnetometer): `v = M (v_raw - offset)`.
///
/// Matrix M holds scale factors, cross-couplings (soft iron for a magnetometer) and the mounting rotation
/// into the gyro's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VectorModel {
    /// Matrix M, row-major, dimensionless.
    pub matrix: [[f32; 3]; 3],
    /// Offset in the sensor's unit (m/s^2, or microtesla: hard iron), subtracted before M.
    pub offset: [f32; 3],
}

impl VectorModel {
    /// Identity model: the raw reading passes through.
    pub const IDENTITY: Self = Self { matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], offset: [0.0; 3] };

    /// Calibrates a raw reading; the result has the reading's unit.
    #[must_use]
    pub fn calibrate(&self, raw: [f32; 3]) -> Vector3<f32> {
        self.matrix() * (Vector3::from(raw) - Vector3::from(self.offset))
    }

    /// Returns true if every parameter is finite and M has a positive determinant.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let finite = are_finite(self.matrix.as_flattened()) && are_finite(&self.offset);
        let determinant = self.matrix().determinant();
        finite && determinant.is_finite() && determinant > 0.0
    }

    fn matrix(&self) -> Matrix3<f32> {
        let [r0, r1, r2] = self.matrix;
        Matrix3::new(r0[0], r0[1], r0[2], r1[0], r1[1], r1[2], r2[0], r2[1], r2[2])
    }
}

impl Default for VectorModel {
    fn default() -> Self {
        Self::IDENTITY
    }
}
