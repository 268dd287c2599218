//! Covariance resets, and the sigmas of the reported angles.

use super::{AttitudeFilter, BIAS, Block, ErrorState, PI, STATES, ToolAngleSigmas, VELOCITY};
use crate::config::AttitudeConfig;
use nalgebra::Vector2;

impl AttitudeFilter {
    #[inline(never)]
    pub(super) fn find_sigmas(&mut self) {
        let (tilt, turned) = (self.config.accel_sigma_m_s2 / self.earth.gravity_m_s2, self.turned_field.doubt());
        let doubt = self.tilt_doubt_rad.component_mul(&self.tilt_doubt_rad);
        let (north, east) = (tilt * tilt + turned + doubt.x, tilt * tilt + turned + doubt.y);
        let mut covariance = self.errors.attitude_covariance();
        covariance.m11 += north;
        covariance.m22 += east;
        covariance.m33 += self.heading_floor + self.heading_doubt + turned;
        if self.gyro_timing_variance > 0.0 {
            let turn = self.rotation * (self.rate_rad_s * self.step_s);
            covariance += turn * turn.transpose() * self.gyro_timing_variance;
        }
        self.sigmas = ToolAngleSigmas::of(&self.rotation, &covariance);
        self.sigmas_stale = false;
    }

    pub(super) fn open_all(&mut self) {
        let Some((config, _)) = self.settings() else { return };
        let bias = config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s;
        let speed = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
        self.errors = ErrorState::new();
        self.sigmas_stale = true;
        for state in 0..STATES {
            self.errors.open(
                state,
                if state < BIAS {
                    PI * PI
                } else if state < VELOCITY {
                    bias
                } else {
                    speed
                },
            );
        }
    }

    pub(super) fn open_bias(&mut self, config: &AttitudeConfig) {
        for k in 0..3 {
            self.errors.open(BIAS + k, config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s);
        }
    }

    /// Resets the velocity and empties the filter step.
    pub(super) fn stop(&mut self, config: &AttitudeConfig) {
        self.velocity_m_s = Vector2::zeros();
        self.errors.open(VELOCITY, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
        self.errors.open(VELOCITY + 1, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
        self.block = Block::new();
    }
}
