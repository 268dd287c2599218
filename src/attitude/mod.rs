//! The attitude filter: compensated rates and calibrated vectors in; inclination, azimuth and toolface out,
//! each with its uncertainty.

mod agreement;
mod consistency;
mod error_state;
mod field_reference;
mod filter;
mod filter_step;
mod gyro_scale;
mod heading;
mod motion;
mod propagation;
mod report;
mod rest;
mod rest_rate;
mod sensor_errors;
mod settings;
mod shaking;
mod slow_turn;
mod state;
mod sustained;
mod tilt;
mod toolface;
mod turned_field;

pub use filter::AttitudeFilter;
pub(crate) use rest::RestTracker;
pub(crate) use toolface::{ToolAngleSigmas, ToolAngles, near_vertical, positive_angle};

bitflags::bitflags! {
    /// Conditions under which an [`Attitude`] was formed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
    #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
    pub struct AttitudeFlags: u16 {
        /// The gyro gave no reading for this sample: the last rate was held.
        const GYRO_HELD = 1;
        /// A gyro axis is at its full scale: the rotation is a lower bound.
        const GYRO_CLIPPED = 1 << 1;
        /// The accelerometer was missing, clipped or rejected for this sample.
        const ACCEL_UNUSED = 1 << 2;
        /// The magnetometer was missing, clipped, zero or rejected for this sample.
        const MAG_UNUSED = 1 << 3;
        /// Heading has never been observed: azimuth counts from an arbitrary north.
        const NO_HEADING = 1 << 4;
        /// The hole is near vertical: azimuth and gravity toolface are singular, `magnetic_toolface_rad` is
        /// exact.
        const NEAR_VERTICAL = 1 << 5;
        /// A gap in time came before this sample: the rotation across it is unknown.
        const AFTER_GAP = 1 << 6;
        /// The driver reported a fault with this sample.
        const FAULT = 1 << 7;
        /// A sensor has not changed its reading for a second, or an axis of the gyro for fifty readings while another
        /// showed that the probe turns.
        const FROZEN_SENSOR = 1 << 8;
    }
}

/// Attitude of the tool at the time of one sample, with 1-sigma uncertainties.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Attitude {
    /// Body to NED, scalar first, unit norm: v_ned = q v_body q*.
    pub q: [f32; 4],
    /// Angle of the tool axis (the body's z, which points down-hole) from the vertical, radians, 0 to pi.
    pub inclination_rad: f32,
    /// Azimuth of the tool axis, radians, 0 to 2 pi; magnetic, or true when a declination is configured.
    pub azimuth_rad: f32,
    /// Gravity toolface, radians, 0 to 2 pi: from the highside of the hole to the body's x, clockwise looking
    /// down-hole.
    pub gravity_toolface_rad: f32,
    /// Magnetic toolface, radians, 0 to 2 pi: azimuth plus gravity toolface near the vertical, defined for
    /// inclinations under pi.
    pub magnetic_toolface_rad: f32,
    /// 1-sigma of the inclination, radians.
    pub sigma_inclination_rad: f32,
    /// 1-sigma of the azimuth, radians.
    pub sigma_azimuth_rad: f32,
    /// 1-sigma of the toolface that applies (gravity, or magnetic near the vertical), radians.
    pub sigma_toolface_rad: f32,
    /// Conditions under which this attitude was formed.
    pub flags: AttitudeFlags,
}
