//! Error model's covariance of a vector sensor's mean.

use crate::config::SurveyErrors;
use nalgebra::{Matrix3, Vector3};

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
