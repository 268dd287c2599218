use crate::sample::SampleFlags;

/// What an inertial source read at one time.
///
/// A part of it that did not read, or is not to be believed, has its `*_MISSING` flag set and zeros in its field.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct InertialReading {
    /// When the part put the reading out, microseconds; the truth is older by the part's latency.
    pub t_us: u64,
    /// Angular rate in the mounted axes, rad/s.
    pub gyro_rad_s: [f32; 3],
    /// Specific force in the mounted axes, m/s^2: at rest it points up, norm about 9.8.
    pub accel_m_s2: [f32; 3],
    /// Temperature of the part, degrees Celsius.
    pub temperature_c: f32,
    /// What is known to be wrong; never one of the magnetometer's flags.
    pub flags: SampleFlags,
}

/// What a magnetic source read at one time.
///
/// A field that did not read, or is not to be believed, has [`SampleFlags::MAG_MISSING`] set and zeros.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct MagneticReading {
    /// When the part put the reading out, microseconds; the truth is older by the part's latency.
    pub t_us: u64,
    /// Magnetic flux density in the mounted axes, microtesla.
    pub mag_ut: [f32; 3],
    /// Temperature of the part, degrees Celsius.
    pub temperature_c: f32,
    /// What is known to be wrong; only the magnetometer's, the temperature's and [`SampleFlags::FAULT`].
    pub flags: SampleFlags,
}
