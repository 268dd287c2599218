//! The attitude as it is stated: angles, their covariance, flags.

use super::AttitudeFilter;
use crate::attitude::{Attitude, AttitudeFlags};
use nalgebra::{Matrix3, Vector3};

impl AttitudeFilter {
    /// Returns the attitude now, with the sample's flags and the filter's own; `None` before the first
    /// alignment. Its sigmas are those of the last filter step, at most 50 ms old.
    pub fn attitude(&mut self, flags: AttitudeFlags) -> Option<Attitude> {
        self.attitude_by_corrected_force(flags, None)
    }

    /// The same where something is taken out of the specific force: its variances on the body's axes, (m/s^2)^2.
    // Inlined: a probe that takes out nothing has no code for it.
    #[inline(always)]
    pub(crate) fn attitude_by_corrected_force(
        &mut self,
        mut flags: AttitudeFlags,
        taken_out_m2_s4: Option<&Vector3<f32>>,
    ) -> Option<Attitude> {
        if !self.tilt.aligned {
            return None;
        }
        if self.report.is_stale {
            let mut covariance = self.attitude_covariance();
            if let Some(variances_m2_s4) = taken_out_m2_s4 {
                self.add_lean(&mut covariance, variances_m2_s4);
            }
            self.report.refresh_sigmas(&self.state, &covariance);
        }
        flags.set(AttitudeFlags::NO_HEADING, !self.heading.is_observed());
        if core::mem::take(&mut self.sample.after_gap) {
            flags.insert(AttitudeFlags::AFTER_GAP);
        }
        if !(self.sample.accel_seen && self.tilt.force_used) {
            flags.insert(AttitudeFlags::ACCEL_UNUSED);
        }
        if !(self.sample.mag_seen && self.heading.is_corrected()) {
            flags.insert(AttitudeFlags::MAG_UNUSED);
        }
        Some(self.report.attitude(&self.state, flags, &self.settings))
    }

    /// Adds the tilt by which a force of these variances on the body's axes, (m/s^2)^2, leans.
    #[inline(never)]
    fn add_lean(&self, covariance: &mut Matrix3<f32>, variances_m2_s4: &Vector3<f32>) {
        if *variances_m2_s4 == Vector3::zeros() {
            return;
        }
        let square = self.settings.earth.gravity_m_s2 * self.settings.earth.gravity_m_s2;
        let to_ned = &self.state.rotation;
        let force = to_ned * Matrix3::from_diagonal(variances_m2_s4) * to_ned.transpose() / square;
        covariance.m11 += force.m22;
        covariance.m22 += force.m11;
        covariance.m12 -= force.m12;
        covariance.m21 -= force.m21;
    }

    /// Covariance of the attitude error, NED, rad^2: the filter's own, and errors that are no states of it.
    #[inline(never)]
    pub(super) fn attitude_covariance(&self) -> Matrix3<f32> {
        let tilt = self.settings.config.accel_sigma_m_s2 / self.settings.earth.gravity_m_s2;
        let turned = self.turned_field.doubt();
        let doubt = self.tilt.doubt_rad.component_mul(&self.tilt.doubt_rad);
        let (north, east) = (tilt * tilt + turned + doubt.x, tilt * tilt + turned + doubt.y);
        let mut covariance = self.state.errors.attitude_covariance();
        // Before a gyro model is identified, its errors are larger than innovations have shown.
        if self.state.scale.is_identified {
            covariance = self.state.consistency.stated(&covariance, self.heading.constant_variance());
        } else {
            covariance.m33 += self.heading.constant_variance();
        }
        covariance.m11 += north;
        covariance.m22 += east;
        // A force that leans one way turns the tilt about one axis.
        let together = self.tilt.doubt_rad.x * self.tilt.doubt_rad.y;
        covariance.m12 -= together;
        covariance.m21 -= together;
        covariance.m33 += self.heading.doubt() + turned;
        // A tilt that the force contradicts turns the heading that the field gave by the tangent of its dip.
        let (_, sine, cosine) = self.heading.reference().dip();
        if self.tilt.has_long_been_doubted() && self.heading.is_observed() && cosine > 0.0 {
            covariance.m33 += (doubt.x + doubt.y) * (sine * sine) / (cosine * cosine);
        }
        let timing_variance = self.sensors.gyro_timing_variance;
        if timing_variance > 0.0 {
            let turn = self.state.rotation * (self.sample.rate_rad_s * self.sample.step_s);
            covariance += turn * turn.transpose() * timing_variance;
        }
        covariance
    }
}
