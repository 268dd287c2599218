//! Report of the attitude.

use super::{
    Attitude, AttitudeFlags,
    settings::Settings,
    state::State,
    toolface::{ToolAngleSigmas, ToolAngles, near_vertical},
};
use nalgebra::Matrix3;

/// Memory of the report: the sigmas of the last filter step, and the last choice of toolface, gravity or magnetic.
pub(super) struct Report {
    sigmas: ToolAngleSigmas,
    /// True if the sigmas must be computed again.
    pub is_stale: bool,
    near_vertical: bool,
}

impl Report {
    /// All zero, for a static.
    pub const ZERO: Self = Self { sigmas: ToolAngleSigmas::UNSET, is_stale: false, near_vertical: false };

    /// Creates a report whose sigmas must be computed.
    pub const fn new() -> Self {
        Self { is_stale: true, ..Self::ZERO }
    }

    /// Computes the sigmas from the covariance of the attitude error, NED, rad^2.
    pub fn refresh_sigmas(&mut self, state: &State, covariance: &Matrix3<f32>) {
        self.sigmas = ToolAngleSigmas::of(&state.rotation, covariance);
        self.is_stale = false;
    }

    /// Returns the attitude of a state, with these flags and that of a near-vertical hole.
    pub fn attitude(&mut self, state: &State, mut flags: AttitudeFlags, settings: &Settings) -> Attitude {
        let angles = ToolAngles::of(&state.rotation);
        let config = &settings.config;
        let (limit, hysteresis) = (config.near_vertical_rad, config.near_vertical_hysteresis_rad);
        self.near_vertical = near_vertical(self.near_vertical, angles.inclination_rad, limit, hysteresis);
        flags.set(AttitudeFlags::NEAR_VERTICAL, self.near_vertical);
        let (q, sigmas) = (state.propagation.q, &self.sigmas);
        Attitude {
            q: [q.w, q.i, q.j, q.k],
            inclination_rad: angles.inclination_rad,
            azimuth_rad: angles.azimuth_rad,
            gravity_toolface_rad: angles.gravity_toolface_rad,
            magnetic_toolface_rad: angles.magnetic_toolface_rad,
            sigma_inclination_rad: sigmas.inclination_rad,
            sigma_azimuth_rad: sigmas.azimuth_rad,
            sigma_toolface_rad: if self.near_vertical {
                sigmas.magnetic_toolface_rad
            } else {
                sigmas.gravity_toolface_rad
            },
            flags,
        }
    }
}
