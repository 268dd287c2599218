//! Report of the attitude.

use super::AttitudeFilter;
use crate::attitude::{Attitude, AttitudeFlags, ToolAngles, near_vertical};

impl AttitudeFilter {
    /// Returns the attitude now, with the sample's flags and the filter's own; `None` before the first
    /// alignment. Its sigmas are those of the last filter step, at most 50 ms old.
    pub fn attitude(&mut self, mut flags: AttitudeFlags) -> Option<Attitude> {
        if !self.aligned {
            return None;
        }
        let angles = ToolAngles::of(&self.rotation);
        if self.sigmas_stale {
            self.find_sigmas();
        }
        let sigmas = &self.sigmas;
        self.near_vertical = near_vertical(
            self.near_vertical,
            angles.inclination_rad,
            self.config.near_vertical_rad,
            self.config.near_vertical_hysteresis_rad,
        );
        flags.set(AttitudeFlags::NEAR_VERTICAL, self.near_vertical);
        flags.set(AttitudeFlags::NO_HEADING, self.heading_blocks == 0);
        flags.set(AttitudeFlags::AFTER_GAP, core::mem::take(&mut self.after_gap));
        if !(self.accel_seen && self.accel_used) {
            flags.insert(AttitudeFlags::ACCEL_UNUSED);
        }
        if !(self.mag_seen && self.mag_used) {
            flags.insert(AttitudeFlags::MAG_UNUSED);
        }
        let q = self.propagation.q;
        Some(Attitude {
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
        })
    }
}
