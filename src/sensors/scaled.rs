//! Scaling of codes to SI units in the body's axes.

use crate::{
    sample::SampleFlags,
    sensors::{InertialReading, MagneticReading},
};

/// Frame with its time, in SI units and the body's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled<const V: usize> {
    pub(super) t_us: u64,
    /// Vector of each sensor, SI; `None` if the sensor did not read, is frozen or is not believed.
    pub(super) vectors: [Option<[f32; 3]>; V],
    pub(super) clipped: [bool; V],
    pub(super) temperature_c: Option<f32>,
}

impl From<Scaled<2>> for InertialReading {
    fn from(scaled: Scaled<2>) -> Self {
        let ([gyro, accel], [gyro_clipped, accel_clipped]) = (scaled.vectors, scaled.clipped);
        let mut flags = SampleFlags::empty();
        flags.set(SampleFlags::GYRO_MISSING, gyro.is_none());
        flags.set(SampleFlags::ACCEL_MISSING, accel.is_none());
        flags.set(SampleFlags::GYRO_CLIPPED, gyro_clipped);
        flags.set(SampleFlags::ACCEL_CLIPPED, accel_clipped);
        flags.set(SampleFlags::TEMPERATURE_MISSING, scaled.temperature_c.is_none());
        Self {
            t_us: scaled.t_us,
            gyro_rad_s: gyro.unwrap_or_default(),
            accel_m_s2: accel.unwrap_or_default(),
            temperature_c: scaled.temperature_c.unwrap_or_default(),
            flags,
        }
    }
}

impl From<Scaled<1>> for MagneticReading {
    fn from(scaled: Scaled<1>) -> Self {
        let ([mag], [clipped]) = (scaled.vectors, scaled.clipped);
        let mut flags = SampleFlags::empty();
        flags.set(SampleFlags::MAG_MISSING, mag.is_none());
        flags.set(SampleFlags::MAG_CLIPPED, clipped);
        flags.set(SampleFlags::TEMPERATURE_MISSING, scaled.temperature_c.is_none());
        Self {
            t_us: scaled.t_us,
            mag_ut: mag.unwrap_or_default(),
            temperature_c: scaled.temperature_c.unwrap_or_default(),
            flags,
        }
    }
}
