//! What the specific force says of the tilt, and rest of the bias.

#![allow(clippy::indexing_slicing)] // Axes of fixed-size vectors, counted by loops.

use super::{ALIGNMENT_SIGMA_RAD, AttitudeFilter};
use crate::{
    attitude::{
        block::Block,
        error_state::{BIAS, Gain, VELOCITY},
    },
    config::{AttitudeConfig, Earth},
};
use core::f32::consts::PI;
use nalgebra::{Vector2, Vector3};

/// Correlation time of the probe's velocity, seconds: of the hand's swing every two seconds a radian.
const VELOCITY_CORRELATION_S: f32 = 0.3;
/// The force's mean square, in parts of gravity's, that no motion keeps for long: accelerations that average out only add to it, and
/// free fall, or an axis that is dead, takes from it. A tenth off in norm, as an accelerometer without a calibration may be, it passes.
const LEAST_MEAN_SQUARE_FORCE: f32 = 0.8;
/// Smoothing of that, seconds: an accelerometer that vibration shakes by 1 g at 10 Hz then reads it to some per cent.
const MEAN_SQUARE_S: f32 = 1.0;
/// A velocity beyond this many sigma weighs less: by chance once in 400.
const VELOCITY_GATE: f32 = 3.0;
/// The tilt starts from the mean force over this time, seconds: a quarter of the time that a start may take, and a shock takes hundredths.
pub(super) const ALIGNMENT_S: f32 = 0.5;
/// Density of the mean rate about the bias at rest, rad/s per root hertz: three times the gyro's noise, for what rest does not exclude.
const REST_RATE_NOISE_RAD_S_RTHZ: f32 = 5e-4;
/// Smoothing of the force that is checked against the attitude, and how long it must contradict it, seconds: what a hand does averages out
/// over its swing.
const CONTRADICTION_S: f32 = 2.0;

impl AttitudeFilter {
    /// The velocity that the force adds up to is an error of the filter, apart from what the probe may really do.
    pub(super) fn observe_velocity(&mut self, force: Option<Vector3<f32>>, time_s: f32, config: &AttitudeConfig) {
        if let Some(force) = force {
            self.velocity_m_s += force.xy() * time_s;
        }
        let moving = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
        let resting = self.rest.square_speed();
        let speed = if self.rest.detected() && resting < moving { resting } else { moving };
        self.accel_used = force.is_some();
        for k in 0..2 {
            let velocity = self.velocity_m_s[k];
            let squared = velocity * velocity;
            let expected = VELOCITY_GATE * VELOCITY_GATE * (self.errors.variance(VELOCITY + k) + speed);
            let mut variance = speed * 2.0 * VELOCITY_CORRELATION_S / time_s;
            if squared > expected {
                variance *= squared / expected;
                self.accel_used = false;
            }
            self.errors.observe(VELOCITY + k, -velocity, variance, Gain::Every);
        }
        let contradicted = force.is_some() && !self.accel_used;
        self.velocity_contradiction_s = if contradicted { self.velocity_contradiction_s + time_s } else { 0.0 };
        if self.velocity_contradiction_s > CONTRADICTION_S {
            // no such speed lasts: the tilt that gave it is wrong by more than the filter thinks, or the force is
            self.velocity_contradiction_s = 0.0;
            self.velocity_m_s = Vector2::zeros();
            for k in 0..2 {
                self.errors.open(VELOCITY + k, speed);
                self.errors.widen(k, ALIGNMENT_SIGMA_RAD * ALIGNMENT_SIGMA_RAD, PI * PI);
            }
            self.open_bias(config);
        }
    }

    /// At rest the mean rate is the bias, unless it is one that the bias cannot have.
    pub(super) fn observe_rest(&mut self, block: &Block) {
        let variance = REST_RATE_NOISE_RAD_S_RTHZ * REST_RATE_NOISE_RAD_S_RTHZ / block.time_s;
        let mean = block.angle_rad / block.time_s;
        let possible = (0..3).all(|k| mean[k] * mean[k] < 9.0 * (self.errors.variance(BIAS + k) + variance));
        if possible {
            for k in 0..3 {
                self.errors.observe(BIAS + k, mean[k], variance, Gain::Every);
            }
        }
    }

    /// Whether the force may be gravity and acceleration: long enough, and not the other way up than the attitude while the field, in
    /// norm and dip, agrees with the attitude.
    pub(super) fn force_is_sound(&mut self, block: &Block, earth: &Earth) -> bool {
        let Some(square) = block.mean_square_force() else { return true };
        let weight = block.time_s / (MEAN_SQUARE_S + block.time_s);
        let gravity = earth.gravity_m_s2 * earth.gravity_m_s2;
        // a shock is not to make up for what is missing longer than seconds
        let share = if square < 16.0 * gravity { square / gravity } else { 16.0 };
        self.mean_square_force += (share - self.mean_square_force) * weight;
        let overturned = self.field_agrees() && !upright(&self.smooth_force_m_s2);
        self.mean_square_force > LEAST_MEAN_SQUARE_FORCE && !overturned
    }

    /// Mean force over seconds points up, whatever the probe does. In the first moments the tilt is taken from it, since a single
    /// reading may have met a shock. Later, if it lies more than 60 deg off, the linear filter has lost its way (upside down it
    /// would never come back) and the tilt is taken anew.
    pub(super) fn check_tilt(
        &mut self,
        force: Option<Vector3<f32>>,
        time_s: f32,
        config: &AttitudeConfig,
        earth: &Earth,
    ) {
        let Some(force) = force else { return };
        self.aligned_s += if self.aligned_s < CONTRADICTION_S { time_s } else { 0.0 };
        self.smooth_force_m_s2 += (force - self.smooth_force_m_s2) * (time_s / (self.aligned_s + time_s));
        let f = &{ self.smooth_force_m_s2 };
        let norm_squared = f.norm_squared();
        let seen = norm_squared > 0.25 * earth.gravity_m_s2 * earth.gravity_m_s2;
        if self.aligned_s < ALIGNMENT_S && seen {
            self.align(f, config, earth);
        }
        let overturned = !upright(f);
        // what a force that is not used says against the tilt is uncertain, about north and about east
        let per_gravity = if seen && !self.accel_used { 1.0 / earth.gravity_m_s2 } else { 0.0 };
        self.tilt_doubt_rad = Vector2::new(f.y, f.x) * per_gravity;
        let contradicted = seen && overturned && !self.field_agrees();
        self.contradiction_s = if contradicted { self.contradiction_s + time_s } else { 0.0 };
        if self.contradiction_s > CONTRADICTION_S {
            self.lost = true;
            self.open_bias(config);
        }
    }
}

/// Whether a mean force, NED, points up within 60 deg.
fn upright(force: &Vector3<f32>) -> bool {
    force.z < 0.0 && force.z * force.z > 0.25 * force.norm_squared()
}
