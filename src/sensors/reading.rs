//! Readings of sources.

use crate::sample::SampleFlags;

/// Reading of an inertial source at one time.
///
/// A sensor that did not read, or whose reading is not believed, has its `*_MISSING` flag set and zeros in its field.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct InertialReading {
    /// Time of the part's output, microseconds; the measured motion is older by the part's latency.
    pub t_us: u64,
    /// Angular rate in the mounted axes, rad/s.
    pub gyro_rad_s: [f32; 3],
    /// Specific force in the mounted axes, m/s^2: at rest it points up, norm about 9.8.
    pub accel_m_s2: [f32; 3],
    /// Temperature of the part, degrees Celsius.
    pub temperature_c: f32,
    /// Known faults; never a flag of the magnetometer.
    pub flags: SampleFlags,
}

/// Reading of a magnetic source at one time.
///
/// A field that was not read, or is not believed, has [`SampleFlags::MAG_MISSING`] set and zeros.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct MagneticReading {
    /// Time of the part's output, microseconds; the measured field is older by the part's latency.
    pub t_us: u64,
    /// Magnetic flux density in the mounted axes, microtesla.
    pub mag_ut: [f32; 3],
    /// Temperature of the part, degrees Celsius.
    pub temperature_c: f32,
    /// Known faults: only the magnetometer's, the temperature's and [`SampleFlags::FAULT`].
    pub flags: SampleFlags,
}
