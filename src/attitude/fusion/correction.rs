//! One filter step, 20 times a second: process noise, prediction and updates.

use super::AttitudeFilter;
use crate::{
    attitude::{block::Block, error_state::Spread},
    config::{AttitudeConfig, Earth},
    rotation::matrix,
};
use nalgebra::Matrix3;

/// Correlation time of scale and coupling errors in one earth direction while motion reverses, seconds: a
/// radian of a swing at 1.6 Hz, as fast as a hand.
const SCALE_CORRELATION_S: f32 = 0.1;
/// White noise of the accelerometer, m/s^2 per root hertz: the upper end of MEMS data sheets (1e-3 to 3e-3;
/// MPU-9250 PS section 3.2: 300 ug). Vibration folded into it is measured separately.
const FORCE_NOISE_M_S2_RTHZ: f32 = 0.003;
/// Spectral density of the acceleration while no force is read, (m/s^2)^2/Hz: 1 m/s^2 correlated over 0.2 s.
pub(super) const UNSEEN_FORCE_DENSITY: f32 = 0.4;

impl AttitudeFilter {
    pub(super) fn close_block(&mut self, config: &AttitudeConfig, earth: &Earth) {
        let block = core::mem::replace(&mut self.block, Block::new());
        let read = block.mean_force();
        let force = if self.force_is_sound(&block, earth) { read } else { None };
        let mut spread = self.spread(&block, force.is_some(), config);
        // Scale and coupling errors act on a sustained rotation as a bias does.
        spread.bias += self.scale_sigma * self.scale_sigma * self.sustained.observe(&block);
        spread.attitude += Matrix3::from_diagonal_element(self.agreement.spread(block.time_s));
        self.unseen_force_s = if force.is_some() { 0.0 } else { self.unseen_force_s + block.time_s };
        self.shaking.observe(force.as_ref(), block.time_s);
        let gravity_time = if force.is_some() { earth.gravity_m_s2 * block.time_s } else { 0.0 };
        self.errors.propagate(&block.rotation_time, gravity_time, &spread);
        self.observe_velocity(force, block.time_s, config);
        if self.rest.detected() {
            self.observe_rest(&block);
        }
        let field = block.mean_field();
        if let Some(field) = &field {
            self.mag_used = self.observe_field(field, &block, config, earth);
            if self.mag_used {
                self.turned_field.agree(field);
            }
        }
        let agreed = self.mag_used && field.is_some();
        if let Some(force) = read {
            self.agreement.observe(&force, field.as_ref(), block.time_s);
            if !agreed && self.heading_blocks > 0 {
                self.contradict(field.as_ref(), config, earth);
            }
        }
        self.unagreed_s = if agreed { 0.0 } else { self.unagreed_s + block.time_s };
        if self.errors.is_sound() {
            let (attitude, bias, velocity) = self.errors.take_correction();
            self.propagation.correct(&attitude);
            self.bias_rad_s += bias;
            self.velocity_m_s += velocity;
        } else {
            self.open_all();
            self.stop(config);
        }
        self.check_tilt(read, block.time_s, config, earth);
        self.rotation = matrix(&self.propagation.q);
        self.sigmas_stale = true;
    }

    fn spread(&self, block: &Block, force_seen: bool, config: &AttitudeConfig) -> Spread {
        let squared_rate = block.squared_rate();
        // Part of a body-fixed error that remains across a rotation's axis, which carries it around.
        let phase = SCALE_CORRELATION_S * SCALE_CORRELATION_S * squared_rate;
        let across_s = SCALE_CORRELATION_S / (1.0 + phase);
        // In a sustained rotation that error is constant and belongs to the bias.
        let reversing = 1.0 - self.sustained.part();
        let scale = self.scale_sigma * self.scale_sigma * block.time_s * reversing;
        let rate_ned = block.rotation_time * block.angle_rad / (block.time_s * block.time_s);
        let noise = config.gyro_noise_rad_s_rthz * config.gyro_noise_rad_s_rthz * block.time_s;
        let along = rate_ned * rate_ned.transpose() * (scale * (SCALE_CORRELATION_S - across_s));
        let (resting, moving) = (self.rest.force_density(self.step_s), FORCE_NOISE_M_S2_RTHZ * FORCE_NOISE_M_S2_RTHZ);
        let noise_density = if self.rest.detected() && resting < moving { resting } else { moving };
        // Vibration of the tool's own axes at the rotation's frequency is slow in the earth frame. The
        // measured density includes the noise.
        let shaken = self.shaking.density() * self.sustained.part();
        let force_density = if shaken > noise_density { shaken } else { noise_density };
        let density = if force_seen { force_density } else { force_density + UNSEEN_FORCE_DENSITY };
        Spread {
            attitude: along + Matrix3::from_diagonal_element(noise + scale * across_s * squared_rate),
            bias: config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * block.time_s,
            velocity: density * block.time_s,
        }
    }
}
