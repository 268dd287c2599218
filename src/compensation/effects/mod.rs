//! Library of effects, one file each.

mod accel_bias;
mod accel_lag;
mod accel_scale;
mod accel_temperature;
mod axial_interference;
mod eddy_lag;
mod g_sensitivity;
mod gyro_bias_step;
mod gyro_bias_temperature;
mod gyro_lag;
mod gyro_scale_asymmetry;
mod gyro_scale_nonlinearity;
mod gyro_scale_temperature;
mod hard_iron;
mod lever_arm;
mod mag_lag;
mod mag_misalignment;
mod mag_temperature;
mod soft_iron;
mod vibration_rectification;

pub use accel_bias::AccelBias;
pub use accel_lag::AccelLag;
pub use accel_scale::AccelScale;
pub use accel_temperature::AccelTemperature;
pub use axial_interference::AxialInterference;
pub use eddy_lag::EddyLag;
pub use g_sensitivity::GSensitivity;
pub use gyro_bias_step::GyroBiasStep;
pub use gyro_bias_temperature::GyroBiasTemperature;
pub use gyro_lag::GyroLag;
pub use gyro_scale_asymmetry::GyroScaleAsymmetry;
pub use gyro_scale_nonlinearity::GyroScaleNonlinearity;
pub use gyro_scale_temperature::GyroScaleTemperature;
pub use hard_iron::HardIron;
pub use lever_arm::LeverArm;
pub use mag_lag::MagLag;
pub use mag_misalignment::MagMisalignment;
pub use mag_temperature::MagTemperature;
pub use soft_iron::SoftIron;
pub use vibration_rectification::VibrationRectification;

use super::effect::Effect;

/// Library of all effects that are looked for by default. Of effects that look alike the likelier comes first.
pub static LIBRARY: [&dyn Effect; 20] = [
    &MagLag,
    &AccelLag,
    &GyroLag,
    &EddyLag,
    &AxialInterference,
    &HardIron,
    &SoftIron,
    &MagMisalignment,
    &AccelBias,
    &AccelScale,
    &LeverArm,
    &GyroBiasTemperature,
    &GyroScaleTemperature,
    &AccelTemperature,
    &MagTemperature,
    &GSensitivity,
    &VibrationRectification,
    &GyroScaleNonlinearity,
    &GyroScaleAsymmetry,
    &GyroBiasStep,
];
