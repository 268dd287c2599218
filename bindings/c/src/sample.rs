//! One reading of all sensors.

use meerkat_mwd::{Sample, SampleFlags};

/// The gyro gave no reading.
pub const MWD_SAMPLE_GYRO_MISSING: u32 = 1;
/// The accelerometer gave no reading.
pub const MWD_SAMPLE_ACCEL_MISSING: u32 = 2;
/// The magnetometer gave no reading.
pub const MWD_SAMPLE_MAG_MISSING: u32 = 4;
/// There is no temperature.
pub const MWD_SAMPLE_TEMPERATURE_MISSING: u32 = 8;
/// A gyro axis is at its full scale.
pub const MWD_SAMPLE_GYRO_CLIPPED: u32 = 16;
/// An accelerometer axis is at its full scale.
pub const MWD_SAMPLE_ACCEL_CLIPPED: u32 = 32;
/// A magnetometer axis is at its full scale.
pub const MWD_SAMPLE_MAG_CLIPPED: u32 = 64;
/// The driver reported a fault: no reading of this sample is used.
pub const MWD_SAMPLE_FAULT: u32 = 128;

/// One reading of all sensors, uncompensated, in the body frame: right-handed, z along the tool axis, down-hole; x
/// across it, to where toolfaces are counted from the hole's highside.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdSample {
    /// Time of acquisition, microseconds; strictly increasing.
    pub t_us: u64,
    /// Angular rate, rad/s.
    pub gyro_rad_s: [f32; 3],
    /// Specific force, m/s^2: at rest it points up, norm about 9.8.
    pub accel_m_s2: [f32; 3],
    /// Magnetic flux density, microtesla.
    pub mag_ut: [f32; 3],
    /// Temperature of the inertial sensor, degrees Celsius.
    pub temperature_c: f32,
    /// Sum of `MWD_SAMPLE_...`; 0 for a sample without faults.
    pub flags: u32,
}

impl MwdSample {
    /// Bits that stand for nothing are dropped.
    pub(crate) fn to_sample(self) -> Sample {
        Sample {
            t_us: self.t_us,
            gyro_rad_s: self.gyro_rad_s,
            accel_m_s2: self.accel_m_s2,
            mag_ut: self.mag_ut,
            temperature_c: self.temperature_c,
            flags: SampleFlags::from_bits_truncate(self.flags as u16),
        }
    }
}

impl From<&Sample> for MwdSample {
    fn from(sample: &Sample) -> Self {
        Self {
            t_us: sample.t_us,
            gyro_rad_s: sample.gyro_rad_s,
            accel_m_s2: sample.accel_m_s2,
            mag_ut: sample.mag_ut,
            temperature_c: sample.temperature_c,
            flags: sample.flags.bits().into(),
        }
    }
}
