//! Covariance of a vector sensor's mean: that of the error model, and that of what was taken out of the readings.

use super::{SurveyInput, six_axis::SixAxisCovariance};
use crate::config::SurveyErrors;
use nalgebra::{Matrix3, Vector3};

/// Variances on each axis of what was taken out of force and field for effects and magnets, the largest over the
/// samples of a mean: one correction serves them all, and its error does not average out.
#[derive(Clone, Copy)]
pub(crate) struct CorrectionVariances {
    force: Vector3<f32>,
    field: Vector3<f32>,
}

impl CorrectionVariances {
    /// Nothing was taken out.
    pub(crate) const NONE: Self = Self { force: Vector3::new(0.0, 0.0, 0.0), field: Vector3::new(0.0, 0.0, 0.0) };

    /// Takes a sample of the mean into account.
    pub(crate) fn include(&mut self, input: &SurveyInput) {
        let larger = |largest: &mut Vector3<f32>, sigma: &[f32; 3]| {
            for (largest, sigma) in largest.iter_mut().zip(sigma) {
                let variance = sigma * sigma;
                *largest = if variance > *largest { variance } else { *largest };
            }
        };
        larger(&mut self.force, &input.force_correction_sigma_m_s2);
        larger(&mut self.field, &input.field_correction_sigma_ut);
    }

    /// Inflates the covariances of means on tool axes.
    pub(crate) fn inflate(&self, means: &mut SixAxisCovariance) {
        for (covariance, variances) in [(&mut means.gravity, &self.force), (&mut means.field, &self.field)] {
            covariance.m11 += variances.x;
            covariance.m22 += variances.y;
            covariance.m33 += variances.z;
        }
    }

    /// Inflates those of means over whole turns about z: across the axis a constant cancels.
    pub(crate) fn inflate_turned(&self, means: &mut SixAxisCovariance) {
        means.gravity.m33 += self.force.z;
        means.field.m33 += self.field.z;
    }
}

/// Covariance of calibrated gravity, tool axes, (m/s^2)^2: independent bias and scale factor on each axis.
pub(crate) fn gravity_covariance(gravity_m_s2: &Vector3<f32>, errors: &SurveyErrors) -> Matrix3<f32> {
    by_axis(gravity_m_s2, errors.accel_bias_m_s2, errors.accel_scale)
}

/// Covariance of the calibrated field, tool axes, microtesla^2: independent bias and scale factor on each
/// axis, plus the drill string's field along z.
pub(crate) fn field_covariance(field_ut: &Vector3<f32>, errors: &SurveyErrors) -> Matrix3<f32> {
    let interference = errors.axial_interference_ut;
    by_axis(field_ut, errors.mag_bias_ut, errors.mag_scale)
        + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, interference * interference))
}

fn by_axis(reading: &Vector3<f32>, bias: f32, scale: f32) -> Matrix3<f32> {
    Matrix3::from_diagonal(&reading.map(|x| bias * bias + scale * scale * x * x))
}

/// Covariance of a mean over whole turns about z, in the frame that does not turn. Biases across the axis
/// cancel; of two scale factors their mean remains, which lengthens the transverse part. The axial part keeps
/// its errors.
pub(crate) fn turned_covariance(reading: &Vector3<f32>, bias: f32, scale: f32) -> Matrix3<f32> {
    let across = Vector3::new(reading.x, reading.y, 0.0);
    let along = bias * bias + scale * scale * reading.z * reading.z;
    across * across.transpose() * (0.5 * scale * scale) + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, along))
}
