//! Full scales of the sensors.

/// Full scales of the sensors; `None` if unknown, in which case that sensor's clipping goes unseen.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct FullScale {
    /// Gyro, rad/s.
    pub gyro_rad_s: Option<f32>,
    /// Accelerometer, m/s^2.
    pub accel_m_s2: Option<f32>,
    /// Magnetometer, microtesla.
    pub mag_ut: Option<f32>,
}
