//! One step of the filter, 20 times a second: what the gathered samples say about the errors.

#![allow(clippy::indexing_slicing)] // Axes of fixed-size vectors, counted by loops.

use super::{ALIGNMENT_SIGMA_RAD, AttitudeFilter, LOST_RAD};
use crate::{
    attitude::{
        block::Block,
        error_state::{BIAS, Gain, HEADING, Spread, VELOCITY},
    },
    config::{AttitudeConfig, Earth},
    rotation::matrix,
};
use core::f32::consts::{PI, TAU};
use nalgebra::{Matrix3, Vector2, Vector3};

/// How long scale and coupling errors of the gyro act in one earth direction, seconds, where motion reverses.
const SCALE_CORRELATION_S: f32 = 0.1;
/// Correlation time of the probe's velocity, seconds: shaking, swinging, a hand.
const VELOCITY_CORRELATION_S: f32 = 0.3;
/// Rotation is sustained that lasts longer than this, seconds: the period of stick-slip is some seconds, gestures are shorter.
const SUSTAINED_S: f32 = 4.0;
/// White noise of the accelerometer including what vibration folds into it, m/s^2 per root hertz (MEMS data sheets: 1e-3 to 3e-3).
const FORCE_NOISE_M_S2_RTHZ: f32 = 0.02;
/// Spectral density of the acceleration while the accelerometer is not seen: 1 m/s^2 correlated over 0.2 s, (m/s^2)^2/Hz.
const UNSEEN_FORCE_DENSITY: f32 = 0.4;
/// Correlation time of the calibrated field's direction error, seconds: it changes as the probe turns in the field.
const FIELD_CORRELATION_S: f32 = 3.0;
/// Correlation time of rate times delay, seconds.
const TIMING_CORRELATION_S: f32 = 0.3;
/// A reading of a magnetometer is held for so long, seconds, from reading to reading another part of it: one at 100 Hz (AK8963, mode 2).
const HOLD_S: f32 = 0.01;
/// The force's mean square, in parts of gravity's, that no motion keeps for long: accelerations that average out only add to it, and
/// free fall, or an axis that is dead, takes from it. A tenth off in norm, as an accelerometer without a calibration may be, it passes.
const LEAST_MEAN_SQUARE_FORCE: f32 = 0.8;
/// Smoothing of that, seconds.
const MEAN_SQUARE_S: f32 = 1.0;
/// The field says nothing of the bias when gravity has not been seen for so long, seconds.
const UNSEEN_FORCE_S: f32 = 1.0;
/// A field that agreed agrees for so long, seconds: some magnetometers are read 8 to 10 times a second.
const AGREEMENT_S: f32 = 0.5;
/// A velocity beyond this many sigma weighs less.
const VELOCITY_GATE: f32 = 3.0;
/// A field's heading beyond this many sigma is not used.
const HEADING_GATE: f32 = 4.0;
/// An undisturbed field that contradicts the heading for this long is believed, seconds.
const HEADING_CONTRADICTION_S: f32 = 30.0;
/// The heading starts as the mean of this many blocks' fields (1 s).
const HEADING_ALIGNMENT_BLOCKS: u16 = 20;
/// The tilt starts from the mean force over this time, seconds.
const ALIGNMENT_S: f32 = 0.5;
/// Density of the mean rate about the bias at rest, rad/s per root hertz: gyro noise and the hand of a resting probe.
const REST_RATE_NOISE_RAD_S_RTHZ: f32 = 5e-4;
/// Smoothing of the force that is checked against the attitude, and how long it must contradict it, seconds.
const CONTRADICTION_S: f32 = 2.0;

impl AttitudeFilter {
    pub(super) fn close_block(&mut self, config: &AttitudeConfig, earth: &Earth) {
        let block = core::mem::replace(&mut self.block, Block::new());
        let read = block.mean_force();
        let force = if self.force_is_sound(&block, earth) { read } else { None };
        let mut spread = self.spread(&block, force.is_some(), config);
        spread.bias += self.sustained_scale(&block);
        self.unseen_force_s = if force.is_some() { 0.0 } else { self.unseen_force_s + block.time_s };
        let gravity_time = if force.is_some() { earth.gravity_m_s2 * block.time_s } else { 0.0 };
        self.errors.propagate(&block.rotation_time, gravity_time, &spread);
        self.observe_velocity(force, block.time_s, config);
        if self.rest.detected() {
            self.observe_rest(&block);
        }
        if let Some(field) = block.mean_field() {
            self.mag_used = self.observe_field(&field, &block, config, earth);
        }
        let agreed = self.mag_used && block.mean_field().is_some();
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
        // what a body-fixed error leaves across the axis of a rotation, which carries it around
        let phase = SCALE_CORRELATION_S * SCALE_CORRELATION_S * squared_rate;
        let across_s = SCALE_CORRELATION_S / (1.0 + phase);
        let scale = self.scale_sigma * self.scale_sigma * block.time_s;
        let rate_ned = block.rotation_time * block.angle_rad / (block.time_s * block.time_s);
        let noise = config.gyro_noise_rad_s_rthz * config.gyro_noise_rad_s_rthz * block.time_s;
        let along = rate_ned * rate_ned.transpose() * (scale * (SCALE_CORRELATION_S - across_s));
        let (resting, moving) = (self.rest.force_density(self.step_s), FORCE_NOISE_M_S2_RTHZ * FORCE_NOISE_M_S2_RTHZ);
        let noise_density = if self.rest.detected() && resting < moving { resting } else { moving };
        let density = noise_density + if force_seen { 0.0 } else { UNSEEN_FORCE_DENSITY };
        Spread {
            attitude: along + Matrix3::from_diagonal_element(noise + scale * across_s * squared_rate),
            bias: config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * block.time_s,
            velocity: density * block.time_s,
        }
    }

    /// Whether the force may be gravity and acceleration: long enough, and not the other way up than the attitude while the field, in
    /// norm and dip, agrees with the attitude.
    fn force_is_sound(&mut self, block: &Block, earth: &Earth) -> bool {
        let Some(square) = block.mean_square_force() else { return true };
        let weight = block.time_s / (MEAN_SQUARE_S + block.time_s);
        let gravity = earth.gravity_m_s2 * earth.gravity_m_s2;
        // a shock is not to make up for what is missing longer than seconds
        let share = if square < 16.0 * gravity { square / gravity } else { 16.0 };
        self.mean_square_force += (share - self.mean_square_force) * weight;
        let overturned = self.field_agrees() && !upright(&self.smooth_force_m_s2);
        self.mean_square_force > LEAST_MEAN_SQUARE_FORCE && !overturned
    }

    /// Whether the field was of late what the attitude makes of it, so that the tilt cannot be far off.
    fn field_agrees(&self) -> bool {
        self.unagreed_s < AGREEMENT_S && self.heading_blocks >= HEADING_ALIGNMENT_BLOCKS
    }

    /// Scale and coupling errors act on a sustained rotation as a bias does: by what the rotation has grown, or waned, grows the
    /// variance of the bias. Rotation is sustained as far as the square of its mean exceeds its variance.
    fn sustained_scale(&mut self, block: &Block) -> f32 {
        let weight = block.time_s / (SUSTAINED_S + block.time_s);
        let mean = block.angle_rad / block.time_s;
        self.sustained_rad_s += (mean - self.sustained_rad_s) * weight;
        self.mean_square_rate += (block.squared_rate() - self.mean_square_rate) * weight;
        let squared = 2.0 * self.sustained_rad_s.norm_squared() - self.mean_square_rate;
        let squared = if squared > 0.0 { squared } else { 0.0 };
        let before = self.sustained_square_rate;
        // what swings with stick-slip is the same rotation still
        let waned = squared < 0.25 * before;
        if squared > before || waned {
            self.sustained_square_rate = squared;
            self.scale_sigma * self.scale_sigma * libm::fabsf(squared - before)
        } else {
            0.0
        }
    }

    /// The velocity that the force adds up to is an error of the filter, apart from what the probe may really do.
    fn observe_velocity(&mut self, force: Option<Vector3<f32>>, time_s: f32, config: &AttitudeConfig) {
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
    fn observe_rest(&mut self, block: &Block) {
        let variance = REST_RATE_NOISE_RAD_S_RTHZ * REST_RATE_NOISE_RAD_S_RTHZ / block.time_s;
        let mean = block.angle_rad / block.time_s;
        let possible = (0..3).all(|k| mean[k] * mean[k] < 9.0 * (self.errors.variance(BIAS + k) + variance));
        if possible {
            for k in 0..3 {
                self.errors.observe(BIAS + k, mean[k], variance, Gain::Every);
            }
        }
    }

    /// Whether the field was used for the heading.
    fn observe_field(&mut self, field: &Vector3<f32>, block: &Block, config: &AttitudeConfig, earth: &Earth) -> bool {
        let horizontal_squared = field.x * field.x + field.y * field.y;
        let norm_squared = field.norm_squared();
        if self.aligned_s < ALIGNMENT_S {
            // a dip that is read against a wrong tilt would become the reference
            return false;
        }
        // within 3 deg of a magnetic pole, or no field
        if norm_squared < 0.01 || horizontal_squared < 0.0025 * norm_squared {
            return false;
        }
        let dip_rad = libm::atan2f(field.z, libm::sqrtf(horizontal_squared));
        let squared_rate = block.squared_rate();
        let compared =
            self.reference.compare(libm::sqrtf(norm_squared), dip_rad, libm::sqrtf(squared_rate), block.time_s, config);
        let Some(deviation) = compared else { return false };
        let north_rad = earth.declination_rad.unwrap_or(0.0);
        let innovation = libm::remainderf(north_rad - libm::atan2f(field.y, field.x), TAU);
        // an error of the field's direction turns the heading the more the steeper the field dips; what is seen of a disturbance
        // in norm and dip is there as much across, unseen
        let steepness = norm_squared / horizontal_squared;
        let direction = (config.mag_sigma_rad * config.mag_sigma_rad + deviation) * steepness;
        let (north_tilt, east_tilt) = (self.errors.variance(0), self.errors.variance(1));
        let tilt = (steepness - 1.0) * if north_tilt > east_tilt { north_tilt } else { east_tilt };
        if self.heading_blocks < HEADING_ALIGNMENT_BLOCKS {
            let settled = tilt < 4.0 * direction && self.errors.variance(HEADING) < LOST_RAD * LOST_RAD;
            self.heading_blocks = if settled { self.heading_blocks + 1 } else { 1 };
            self.errors.open(HEADING, direction + tilt);
            self.turn_heading(innovation / f32::from(self.heading_blocks));
            self.heading_floor = 0.25 * config.mag_sigma_rad * config.mag_sigma_rad * steepness;
            return true;
        }
        let timing = self.timing_variance_s2 * squared_rate;
        let hold = HOLD_S * HOLD_S / 12.0 * squared_rate;
        let expected = self.errors.variance(HEADING) + direction + 4.0 * (timing + hold) + tilt;
        if innovation * innovation > HEADING_GATE * HEADING_GATE * expected {
            self.heading_contradiction_s += block.time_s;
            self.heading_doubt = innovation * innovation;
            if self.heading_contradiction_s > HEADING_CONTRADICTION_S {
                self.errors.open(HEADING, innovation * innovation);
            }
            return false;
        }
        self.heading_contradiction_s = 0.0;
        self.heading_doubt = 0.0;
        let density = 2.0 * (direction * FIELD_CORRELATION_S + timing * TIMING_CORRELATION_S) + hold * HOLD_S;
        let gain = if self.unseen_force_s < UNSEEN_FORCE_S { Gain::HeadingAndBias } else { Gain::Heading };
        self.errors.observe(HEADING, innovation, density / block.time_s + tilt, gain);
        // an error that is constant in the probe does not average out while the probe keeps its attitude: half of it is of that kind
        self.heading_floor = 0.25 * config.mag_sigma_rad * config.mag_sigma_rad * steepness;
        true
    }

    /// Mean force over seconds points up, whatever the probe does. In the first moments the tilt is taken from it, since a single
    /// reading may have met a shock. Later, if it lies more than 60 deg off, the linear filter has lost its way (upside down it
    /// would never come back) and the tilt is taken anew.
    fn check_tilt(&mut self, force: Option<Vector3<f32>>, time_s: f32, config: &AttitudeConfig, earth: &Earth) {
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
