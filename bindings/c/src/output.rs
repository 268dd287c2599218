//! Output of one sample.

use meerkat_mwd::{
    attitude::{Attitude, AttitudeFlags},
    probe::Output,
};

/// The gyro gave no reading for this sample: the last rate was held.
pub const MWD_ATTITUDE_GYRO_HELD: u32 = 1;
/// A gyro axis is at its full scale: the rotation is a lower bound.
pub const MWD_ATTITUDE_GYRO_CLIPPED: u32 = 2;
/// The accelerometer was missing, clipped or rejected for this sample.
pub const MWD_ATTITUDE_ACCEL_UNUSED: u32 = 4;
/// The magnetometer was missing, clipped, zero or rejected for this sample.
pub const MWD_ATTITUDE_MAG_UNUSED: u32 = 8;
/// Heading has never been observed: azimuth counts from an arbitrary north.
pub const MWD_ATTITUDE_NO_HEADING: u32 = 16;
/// The hole is near vertical: the magnetic toolface applies.
pub const MWD_ATTITUDE_NEAR_VERTICAL: u32 = 32;
/// A gap in time came before this sample.
pub const MWD_ATTITUDE_AFTER_GAP: u32 = 64;
/// The driver reported a fault with this sample.
pub const MWD_ATTITUDE_FAULT: u32 = 128;
/// A sensor has not changed its reading for a second.
pub const MWD_ATTITUDE_FROZEN_SENSOR: u32 = 256;

/// Attitude of the tool at one time, with 1-sigma uncertainties.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdAttitude {
    /// Body to north-east-down, scalar first, unit norm.
    pub q: [f32; 4],
    /// Angle of the tool axis from the vertical, radians, 0 to pi.
    pub inclination_rad: f32,
    /// Azimuth of the tool axis, radians, 0 to 2 pi; magnetic, or true when a declination is configured.
    pub azimuth_rad: f32,
    /// Gravity toolface, radians, 0 to 2 pi, clockwise looking down-hole.
    pub gravity_toolface_rad: f32,
    /// Magnetic toolface, radians, 0 to 2 pi.
    pub magnetic_toolface_rad: f32,
    /// 1-sigma of the inclination, radians.
    pub sigma_inclination_rad: f32,
    /// 1-sigma of the azimuth, radians.
    pub sigma_azimuth_rad: f32,
    /// 1-sigma of the toolface that applies: gravity, or magnetic near the vertical, radians.
    pub sigma_toolface_rad: f32,
    /// Sum of `MWD_ATTITUDE_...`.
    pub flags: u32,
}

/// Output of one sample.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdOutput {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Compensated body rate relative to the earth, rad/s.
    pub rate_rad_s: [f32; 3],
    /// 1 if there is an attitude; 0 before the first gravity reading has aligned the filter.
    pub has_attitude: u32,
    /// The attitude; zeros without one.
    pub attitude: MwdAttitude,
}

impl From<&Attitude> for MwdAttitude {
    fn from(attitude: &Attitude) -> Self {
        Self {
            q: attitude.q,
            inclination_rad: attitude.inclination_rad,
            azimuth_rad: attitude.azimuth_rad,
            gravity_toolface_rad: attitude.gravity_toolface_rad,
            magnetic_toolface_rad: attitude.magnetic_toolface_rad,
            sigma_inclination_rad: attitude.sigma_inclination_rad,
            sigma_azimuth_rad: attitude.sigma_azimuth_rad,
            sigma_toolface_rad: attitude.sigma_toolface_rad,
            flags: attitude.flags.bits().into(),
        }
    }
}

impl MwdAttitude {
    fn to_attitude(self) -> Attitude {
        Attitude {
            q: self.q,
            inclination_rad: self.inclination_rad,
            azimuth_rad: self.azimuth_rad,
            gravity_toolface_rad: self.gravity_toolface_rad,
            magnetic_toolface_rad: self.magnetic_toolface_rad,
            sigma_inclination_rad: self.sigma_inclination_rad,
            sigma_azimuth_rad: self.sigma_azimuth_rad,
            sigma_toolface_rad: self.sigma_toolface_rad,
            flags: AttitudeFlags::from_bits_truncate(self.flags as u16),
        }
    }
}

impl From<&Output> for MwdOutput {
    fn from(output: &Output) -> Self {
        Self {
            t_us: output.t_us,
            rate_rad_s: output.rate_rad_s,
            has_attitude: output.attitude.is_some().into(),
            attitude: output.attitude.as_ref().map(MwdAttitude::from).unwrap_or_default(),
        }
    }
}

impl MwdOutput {
    pub(crate) fn to_output(self) -> Output {
        Output {
            t_us: self.t_us,
            rate_rad_s: self.rate_rad_s,
            attitude: (self.has_attitude != 0).then(|| self.attitude.to_attitude()),
        }
    }
}
