//! Errors of real sensors beside the gyro's twelve and noise. All are off by default.

mod accelerometer;
#[cfg(test)]
mod clean_run;
mod delay;
mod disturber;
mod dropouts;
mod gyro;
mod gyro_bias;
mod hard_iron_interval;
mod magnetic_bursts;
mod magnetometer;
mod mount_rotation;
mod poisson;
mod settings;
mod validation;

pub(super) use disturber::Disturber;
pub use dropouts::Dropouts;
pub(super) use gyro_bias::bias_step;
pub use hard_iron_interval::HardIronInterval;
pub use magnetic_bursts::MagneticBursts;
pub use mount_rotation::MountRotation;
pub use settings::Effects;
