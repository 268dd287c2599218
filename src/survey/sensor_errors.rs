//! What the error model leaves uncertain in the mean of a vector sensor.

use crate::config::SurveyErrors;
use nalgebra::{Matrix3, Vector3};

/// Covariance of calibrated gravity, tool axes, (m/s^2)^2: bias and scale factor of each axis on its own.
pub(crate) fn gravity_covariance(gravity_m_s2: &Vector3<f32>, errors: &SurveyErrors) -> Matrix3<f32> {
    by_axis(gravity_m_s2, errors.accel_bias_m_s2, errors.accel_scale)
}

/// Covariance of the calibrated field, tool axes, microtesla^2: bias and scale factor of each axis on its own, and what the drill
/// string adds along z.
pub(crate) fn field_covariance(field_ut: &Vector3<f32>, errors: &SurveyErrors) -> Matrix3<f32> {
    let interference = errors.axial_interference_ut;
    by_axis(field_ut, errors.mag_bias_ut, errors.mag_scale)
        + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, interference * interference))
}

fn by_axis(reading: &Vector3<f32>, bias: f32, scale: f32) -> Matrix3<f32> {
    Matrix3::from_diagonal(&reading.map(|x| bias * bias + scale * scale * x * x))
}

/// The same for a mean over whole turns about z, in the frame that does not turn: the biases across the axis cancel, and of two scale
/// factors their mean is left, which lengthens what lies across. Along the axis nothing changes.
pub(crate) fn turned_covariance(reading: &Vector3<f32>, bias: f32, scale: f32) -> Matrix3<f32> {
    let across = Vector3::new(reading.x, reading.y, 0.0);
    let along = bias * bias + scale * scale * reading.z * reading.z;
    across * across.transpose() * (0.5 * scale * scale) + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, along))
}
