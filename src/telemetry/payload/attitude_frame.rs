//! Angles of one sample, quantised for the line.

use super::Payload;
use crate::{
    attitude::{Attitude, AttitudeFlags},
    probe::Output,
    telemetry::Kind,
};
use core::f32::consts::TAU;
use postcard::fixint::le;
use serde::{Deserialize, Serialize};

/// Steps of a whole turn.
const STEPS_PER_TURN: f32 = 65_536.0;

/// Steps of a radian of a standard deviation.
const SIGMA_STEPS_PER_RAD: f32 = 10_000.0;

/// Angles of one sample, in about 20 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttitudeFrame {
    /// Time of validity, microseconds.
    pub t_us: u64,
    /// Angles; `None` before the attitude filter is first aligned by gravity.
    pub angles: Option<CompactAngles>,
}

/// Angles rounded to steps of a 65,536th of a turn (0.0055 deg); standard deviations rounded to steps of 0.0001 rad,
/// but to 0 only if they are 0, and at most 6.55 rad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompactAngles {
    // Two bytes each: angles use all 16 bits, and most of them would take three as a varint.
    #[serde(with = "le")]
    inclination: u16,
    #[serde(with = "le")]
    azimuth: u16,
    #[serde(with = "le")]
    gravity_toolface: u16,
    #[serde(with = "le")]
    magnetic_toolface: u16,
    sigma_inclination: u16,
    sigma_azimuth: u16,
    sigma_toolface: u16,
    flags: AttitudeFlags,
}

impl AttitudeFrame {
    /// Quantises an output. An attitude that is not finite becomes `None`.
    #[must_use]
    pub fn of(output: &Output) -> Self {
        Self { t_us: output.t_us, angles: output.attitude.as_ref().and_then(CompactAngles::of) }
    }
}

impl CompactAngles {
    fn of(attitude: &Attitude) -> Option<Self> {
        let angles = [
            attitude.inclination_rad,
            attitude.azimuth_rad,
            attitude.gravity_toolface_rad,
            attitude.magnetic_toolface_rad,
        ];
        let sigmas = [attitude.sigma_inclination_rad, attitude.sigma_azimuth_rad, attitude.sigma_toolface_rad];
        if !angles.iter().chain(&sigmas).all(|x| x.is_finite()) {
            return None;
        }
        // A whole turn wraps to 0.
        let [inclination, azimuth, gravity_toolface, magnetic_toolface] =
            angles.map(|x| libm::roundf(libm::remainderf(x, TAU) * (STEPS_PER_TURN / TAU)) as i32 as u16);
        let [sigma_inclination, sigma_azimuth, sigma_toolface] = sigmas.map(|x| {
            let steps = libm::roundf(x * SIGMA_STEPS_PER_RAD) as u16;
            steps.max(u16::from(x > 0.0))
        });
        Some(Self {
            inclination,
            azimuth,
            gravity_toolface,
            magnetic_toolface,
            sigma_inclination,
            sigma_azimuth,
            sigma_toolface,
            flags: attitude.flags,
        })
    }

    /// Angle of the tool axis from the vertical, radians, 0 to pi.
    #[must_use]
    pub fn inclination_rad(&self) -> f32 {
        angle_rad(self.inclination)
    }

    /// Azimuth, radians, 0 to 2 pi; magnetic, or true when a declination is configured.
    #[must_use]
    pub fn azimuth_rad(&self) -> f32 {
        angle_rad(self.azimuth)
    }

    /// Gravity toolface, radians, 0 to 2 pi, clockwise looking down-hole.
    #[must_use]
    pub fn gravity_toolface_rad(&self) -> f32 {
        angle_rad(self.gravity_toolface)
    }

    /// Magnetic toolface, radians, 0 to 2 pi.
    #[must_use]
    pub fn magnetic_toolface_rad(&self) -> f32 {
        angle_rad(self.magnetic_toolface)
    }

    /// 1-sigma of inclination, azimuth and the toolface that applies, radians.
    #[must_use]
    pub fn sigmas_rad(&self) -> [f32; 3] {
        [self.sigma_inclination, self.sigma_azimuth, self.sigma_toolface].map(|x| f32::from(x) / SIGMA_STEPS_PER_RAD)
    }

    /// Conditions under which the attitude was formed.
    #[must_use]
    pub const fn flags(&self) -> AttitudeFlags {
        self.flags
    }
}

fn angle_rad(steps: u16) -> f32 {
    f32::from(steps) * (TAU / STEPS_PER_TURN)
}

impl Payload for AttitudeFrame {
    const KIND: Kind = Kind::Attitude;
}
