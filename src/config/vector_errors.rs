//! Errors that calibrations leave in accelerometer and magnetometer.

use super::ConfigError;

/// Errors left by the calibrations of accelerometer and magnetometer, one standard deviation each: the prior of the
/// errors that the estimator identifies beside the gyro's. The defaults are data-sheet values of uncalibrated sensors;
/// `cargo mwd calibrate` writes those of its calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct VectorErrors {
    /// Elements of the magnetometer's matrix, except its scale. Default 0.03: sensitivity and cross-axis of
    /// BMM150 and IIS2MDC are 1 to 3 %.
    pub mag_matrix: f32,
    /// Hard iron, relative to the earth field's norm. Default 0.1: zero-field offset 5 uT (IIS2MDC), and the
    /// probe's own magnetism.
    pub hard_iron: f32,
    /// Delay of the magnetometer behind the gyro, seconds. Default 0.015: conversion and hold at 100 Hz.
    pub mag_lag_s: f32,
    /// Elements of the accelerometer's matrix. Default 0.005: sensitivity of LSM6DSO and ICM-42688-P.
    pub accel_matrix: f32,
    /// Bias of the accelerometer, m/s^2. Default 0.2: zero-g level 20 mg of LSM6DSO and ICM-42688-P.
    pub accel_bias_m_s2: f32,
    /// Delay of the accelerometer behind the gyro, seconds. Default 0.005: the difference of two low-passes.
    pub accel_lag_s: f32,
}

impl VectorErrors {
    /// All-zero settings of a static before it is configured.
    pub(crate) const UNSET: Self = Self {
        mag_matrix: 0.0,
        hard_iron: 0.0,
        mag_lag_s: 0.0,
        accel_matrix: 0.0,
        accel_bias_m_s2: 0.0,
        accel_lag_s: 0.0,
    };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        // Upper bounds, three to ten times what data sheets allow (3 % for a matrix element, 5 uT of hard iron in a
        // field of 50 uT): a sensor with larger errors is broken. A delay of 0.3 s is nearly a turn at 180 rpm.
        let bounded = [
            (self.mag_matrix, 0.3, "identification.vector_errors.mag_matrix"),
            (self.hard_iron, 0.3, "identification.vector_errors.hard_iron"),
            (self.mag_lag_s, 0.3, "identification.vector_errors.mag_lag_s"),
            (self.accel_matrix, 0.3, "identification.vector_errors.accel_matrix"),
            (self.accel_bias_m_s2, 3.0, "identification.vector_errors.accel_bias_m_s2"),
            (self.accel_lag_s, 0.3, "identification.vector_errors.accel_lag_s"),
        ];
        for (value, most, field) in bounded {
            if !(value > 0.0 && value <= most) {
                return Err(ConfigError { field, must_be: "above 0 and at most 0.3 (accel_bias_m_s2: 3)" });
            }
        }
        Ok(())
    }
}

impl Default for VectorErrors {
    fn default() -> Self {
        Self {
            mag_matrix: 0.03,
            hard_iron: 0.1,
            mag_lag_s: 0.015,
            accel_matrix: 0.005,
            accel_bias_m_s2: 0.2,
            accel_lag_s: 0.005,
        }
    }
}
