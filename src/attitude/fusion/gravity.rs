//! Updates by gravity, through velocity, and by rest.

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

/// Correlation time of the probe's velocity, seconds: a radian of a hand's swing every two seconds.
const VELOCITY_CORRELATION_S: f32 = 0.3;
/// Least mean square of the force relative to gravity's that lasts. Accelerations that average out only add
/// to it; free fall or a dead axis takes from it. An accelerometer whose norm is a tenth low, as without a
/// calibration, passes.
const LEAST_MEAN_SQUARE_FORCE: f32 = 0.8;
/// Averaging time of that mean square, seconds: vibration of 1 g at 10 Hz then changes it by some per cent.
const MEAN_SQUARE_S: f32 = 1.0;
/// Gate of the velocity, in sigmas, beyond which it weighs less: exceeded by chance once in 400.
const VELOCITY_GATE: f32 = 3.0;
/// Time over which the first tilt averages the force, seconds: a quarter of the time that a start may take; a
/// shock takes hundredths.
pub(super) const ALIGNMENT_S: f32 = 0.5;
/// Density of the mean rate about the bias at rest, rad/s per root hertz: three times the gyro's noise, for
/// slow motion that rest admits.
const REST_RATE_NOISE_RAD_S_RTHZ: f32 = 5e-4;
/// Smoothing of the force that is checked against the attitude, and the time for which it must contradict,
/// seconds: a hand's motion averages out over its swing.
const CONTRADICTION_S: f32 = 2.0;

impl AttitudeFilter {
    /// Updates by the integrated force: velocity beyond the probe's plausible speed is an error of the
    /// filter.
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
            // No such speed lasts: the tilt behind it is worse than the filter thinks, or the force is.
            self.velocity_contradiction_s = 0.0;
            self.velocity_m_s = Vector2::zeros();
            for k in 0..2 {
                self.errors.open(VELOCITY + k, speed);
                self.errors.widen(k, ALIGNMENT_SIGMA_RAD * ALIGNMENT_SIGMA_RAD, PI * PI);
            }
            self.open_bias(config);
        }
    }

    /// Updates the bias by the mean rate at rest, unless that rate is implausible as a bias.
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

    /// Returns true if the force can be gravity plus acceleration: long enough, and not upside down while the
    /// field agrees with the attitude.
    pub(super) fn force_is_sound(&mut self, block: &Block, earth: &Earth) -> bool {
        let Some(square) = block.mean_square_force() else { return true };
        let weight = block.time_s / (MEAN_SQUARE_S + block.time_s);
        let gravity = earth.gravity_m_s2 * earth.gravity_m_s2;
        // Capped, so that a shock hides a missing axis for seconds at most.
        let share = if square < 16.0 * gravity { square / gravity } else { 16.0 };
        self.mean_square_force += (share - self.mean_square_force) * weight;
        let overturned = self.field_agrees() && !upright(&self.smooth_force_m_s2);
        self.mean_square_force > LEAST_MEAN_SQUARE_FORCE && !overturned
    }

    /// Checks the tilt by the mean force over seconds, which points up whatever the probe does. At first the
    /// tilt is taken from it, since a single reading may have met a shock. Later a mean force more than 60
    /// deg off means that the linear filter is lost (upside down it would never recover), and the tilt is
    /// taken again.
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
        // A force that is not used makes the tilt uncertain by its angle, about north and about east.
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

/// Returns true if a mean force, NED, points up within 60 deg.
fn upright(force: &Vector3<f32>) -> bool {
    force.z < 0.0 && force.z * force.z > 0.25 * force.norm_squared()
}
