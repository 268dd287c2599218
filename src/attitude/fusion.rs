use super::{
    Attitude, AttitudeFlags,
    block::Block,
    error_state::{BIAS, ErrorState, Gain, HEADING, STATES, Spread, VELOCITY},
    field_reference::FieldReference,
    propagation::Propagation,
    rest::Rest,
    toolface::{ToolAngleSigmas, ToolAngles, near_vertical},
};
use crate::{
    config::{AttitudeConfig, Earth},
    rotation::{exp_matrix, matrix, renormalised},
};
use core::f32::consts::{PI, TAU};
use nalgebra::{Matrix3, Quaternion, Vector2, Vector3};

/// One filter step gathers samples for about this long, seconds.
const BLOCK_S: f32 = 0.02;
/// How long scale and coupling errors of the gyro act in one earth direction, seconds, where motion reverses.
const SCALE_CORRELATION_S: f32 = 0.1;
/// Correlation time of the probe's velocity, seconds: shaking, swinging, a hand.
const VELOCITY_CORRELATION_S: f32 = 0.3;
/// White noise of the accelerometer including what vibration folds into it, m/s^2 per root hertz (MEMS data sheets: 1e-3 to 3e-3).
const FORCE_NOISE_M_S2_RTHZ: f32 = 0.02;
/// Spectral density of the acceleration while the accelerometer is not seen: 1 m/s^2 correlated over 0.2 s, (m/s^2)^2/Hz.
const UNSEEN_FORCE_DENSITY: f32 = 0.4;
/// Correlation time of the calibrated field's direction error, seconds: it changes as the probe turns in the field.
const FIELD_CORRELATION_S: f32 = 3.0;
/// Correlation time of rate times delay, seconds.
const TIMING_CORRELATION_S: f32 = 0.3;
/// A velocity beyond this many sigma weighs less, a field's heading beyond [`HEADING_GATE`] is not used.
const VELOCITY_GATE: f32 = 3.0;
const HEADING_GATE: f32 = 4.0;
/// An undisturbed field that contradicts the heading for this long is believed, seconds.
const HEADING_CONTRADICTION_S: f32 = 30.0;
/// The heading starts as the mean of this many blocks' fields (1 s).
const HEADING_ALIGNMENT_BLOCKS: u16 = 50;
/// Uncertainty of a tilt taken from a force that is as long as gravity, radians: 0.1 g of acceleration.
const ALIGNMENT_SIGMA_RAD: f32 = 0.1;
/// The tilt starts from the mean force over this time, seconds.
const ALIGNMENT_S: f32 = 0.5;
/// Density of the mean rate about the bias at rest, rad/s per root hertz: gyro noise and the hand of a resting probe.
const REST_RATE_NOISE_RAD_S_RTHZ: f32 = 5e-4;
/// Smoothing of the force that is checked against the attitude, and how long it must contradict it, seconds.
const CONTRADICTION_S: f32 = 2.0;
/// A rate that is assumed where none was read, added to the last one, rad/s.
const UNSEEN_RATE_RAD_S: f32 = 0.3;
/// A rotation less certain than this is found anew from gravity and field, radians.
const LOST_RAD: f32 = 0.3;
/// Earth's rotation, rad/s (WGS 84).
const EARTH_RATE_RAD_S: f32 = 7.292_115e-5;

/// The attitude filter: strapdown propagation at the sample rate, corrected 50 times a second.
///
/// An error-state Kalman filter over attitude, residual gyro bias and horizontal velocity. The accelerometer is integrated to
/// a velocity, and the only thing claimed about it is that velocity is bounded: a wrong tilt makes the integral of gravity run
/// away, vibration, shocks and a moving hand do not. So no reading is ever called "gravity", and averaging is as long as the
/// gyro allows. The field corrects the heading (and the bias), never the tilt, and only while its norm and dip agree with an
/// undisturbed reference. Errors are correlated in time; each enters as white noise with the same density at low frequency.
///
/// All zero until [`AttitudeFilter::start`], so that a `static` of it costs no flash.
pub struct AttitudeFilter {
    config: Option<(AttitudeConfig, Earth)>,
    propagation: Propagation,
    errors: ErrorState,
    reference: FieldReference,
    rest: Rest,
    block: Block,
    bias_rad_s: Vector3<f32>,
    velocity_m_s: Vector2<f32>,
    rate_rad_s: Vector3<f32>,
    step_s: f32,
    smooth_force_m_s2: Vector3<f32>,
    /// Since the tilt was last taken from the force, up to [`CONTRADICTION_S`], seconds.
    aligned_s: f32,
    contradiction_s: f32,
    heading_contradiction_s: f32,
    heading_blocks: u16,
    /// Variance of the heading that no averaging takes away, rad^2.
    heading_floor: f32,
    aligned: bool,
    lost: bool,
    near_vertical: bool,
    after_gap: bool,
    accel_used: bool,
    mag_used: bool,
    accel_seen: bool,
    mag_seen: bool,
}

impl AttitudeFilter {
    /// A filter that has not been started.
    #[must_use]
    pub const fn new() -> Self {
        const ZERO: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
        Self {
            config: None,
            propagation: Propagation::new(),
            errors: ErrorState::new(),
            reference: FieldReference::new(),
            rest: Rest::new(),
            block: Block::new(),
            bias_rad_s: ZERO,
            velocity_m_s: Vector2::new(0.0, 0.0),
            rate_rad_s: ZERO,
            step_s: 0.0,
            smooth_force_m_s2: ZERO,
            aligned_s: 0.0,
            contradiction_s: 0.0,
            heading_contradiction_s: 0.0,
            heading_blocks: 0,
            heading_floor: 0.0,
            aligned: false,
            lost: false,
            near_vertical: false,
            after_gap: false,
            accel_used: false,
            mag_used: false,
            accel_seen: false,
            mag_seen: false,
        }
    }

    /// Starts afresh. The configuration must have passed [`crate::Config::validate`].
    pub fn start(&mut self, config: &AttitudeConfig, earth: &Earth) {
        *self = Self::new();
        self.config = Some((*config, *earth));
        self.reference = FieldReference::start(earth);
        self.open_all();
    }

    /// Steps over the `dt_s` seconds that end with this sample, with its compensated body rate (or the last one held).
    pub fn propagate(&mut self, dt_s: f32, rate_rad_s: &Vector3<f32>) {
        let Some((config, _)) = self.config else { return };
        // beyond any gyro (57,000 deg/s): a defect of the reading, about which nothing is known
        let plausible = rate_rad_s.norm_squared() < 1e6;
        self.rate_rad_s = if plausible { *rate_rad_s } else { Vector3::zeros() };
        self.step_s = dt_s;
        if !self.aligned {
            return;
        }
        if !plausible {
            self.doubt(PI);
        }
        let rate = self.rate_rad_s - self.bias_rad_s;
        self.propagation.step(dt_s, &rate, config.gyro_delay_s);
        self.block.turn(&matrix(&self.propagation.q), &rate, dt_s);
    }

    /// Takes the vectors read with the sample: calibrated specific force (m/s^2, up at rest) and field (microtesla), body
    /// frame; `None` for what is missing, clipped or known to be wrong. Call after every [`AttitudeFilter::propagate`].
    pub fn observe(&mut self, accel_m_s2: Option<&Vector3<f32>>, mag_ut: Option<&Vector3<f32>>) {
        let Some((config, earth)) = self.config else { return };
        // sensors end at some 200 g and some 5 mT
        let accel = accel_m_s2.filter(|a| a.norm_squared() < 1e8);
        let mag = mag_ut.filter(|m| m.norm_squared() < 1e8 && m.norm_squared() > 1e-2);
        (self.accel_seen, self.mag_seen) = (accel.is_some(), mag.is_some());
        self.rest.observe(&self.rate_rad_s, accel, self.step_s);
        if !self.aligned || self.lost {
            // in free fall there is no direction to take
            let least = 0.01 * earth.gravity_m_s2 * earth.gravity_m_s2;
            if let Some(force) = accel.filter(|a| a.norm_squared() > least) {
                self.align(&(matrix(&self.propagation.q) * force), &config, &earth);
                (self.aligned_s, self.contradiction_s) = (0.0, 0.0);
                return;
            }
            if !self.aligned {
                return;
            }
        }
        let c = matrix(&self.propagation.q);
        if let Some(force) = accel {
            self.block.force(&(c * force));
        }
        if let Some(field) = mag {
            self.block.field(&(c * field));
        }
        if self.block.time_s + 0.5 * self.step_s >= BLOCK_S {
            self.close_block(&config, &earth);
        }
    }

    /// The attitude now, with the flags of the sample and the filter's own; `None` until a first specific force aligned it.
    pub fn attitude(&mut self, mut flags: AttitudeFlags) -> Option<Attitude> {
        let (config, earth) = self.config?;
        if !self.aligned {
            return None;
        }
        let c = matrix(&self.propagation.q);
        let angles = ToolAngles::of(&c);
        let tilt = config.accel_sigma_m_s2 / earth.gravity_m_s2;
        let unobserved = Vector3::new(tilt * tilt, tilt * tilt, self.heading_floor);
        let sigmas =
            ToolAngleSigmas::of(&c, &(self.errors.attitude_covariance() + Matrix3::from_diagonal(&unobserved)));
        self.near_vertical = near_vertical(
            self.near_vertical,
            angles.inclination_rad,
            config.near_vertical_rad,
            config.near_vertical_hysteresis_rad,
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

    /// Residual gyro bias found by the filter, body frame, rad/s, to be subtracted from the compensated rate.
    #[must_use]
    pub const fn residual_bias_rad_s(&self) -> Vector3<f32> {
        self.bias_rad_s
    }

    /// The gyro model has been swapped: the residual bias belongs to the old one. The attitude does not move.
    pub fn model_changed(&mut self) {
        let Some((config, _)) = self.config else { return };
        self.bias_rad_s = Vector3::zeros();
        for k in 0..3 {
            self.errors.open(BIAS + k, config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s);
        }
    }

    /// The rotation of this sample is uncertain by `angle_rad` about each axis, beyond the gyro's noise (held or clipped rate).
    pub fn doubt(&mut self, angle_rad: f32) {
        for k in 0..3 {
            self.errors.widen(k, angle_rad * angle_rad, PI * PI);
        }
    }

    /// `dt_s` seconds before this sample were not seen: the attitude is kept, its uncertainty grows by what the probe may have
    /// turned, and when that is much, gravity and field are taken anew as soon as they are seen. To be followed by
    /// [`AttitudeFilter::observe`] without [`AttitudeFilter::propagate`].
    pub fn gap(&mut self, dt_s: f32) {
        let Some((config, _)) = self.config else { return };
        let limited_s = if dt_s < 100.0 { dt_s } else { 100.0 };
        let angle_rad = (libm::sqrtf(self.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S) * limited_s;
        self.doubt(if angle_rad < PI { angle_rad } else { PI });
        let walk = config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * limited_s;
        for k in 0..3 {
            self.errors.widen(BIAS + k, walk, config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s);
        }
        self.stop(&config);
        self.propagation.interrupt();
        self.rest = Rest::new();
        self.lost = self.lost || angle_rad > LOST_RAD;
        self.after_gap = true;
        self.step_s = 0.0;
    }

    fn open_all(&mut self) {
        let Some((config, _)) = self.config else { return };
        let bias = config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s;
        let speed = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
        self.errors = ErrorState::new();
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

    /// Velocity unknown, block empty.
    fn stop(&mut self, config: &AttitudeConfig) {
        self.velocity_m_s = Vector2::zeros();
        self.errors.open(VELOCITY, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
        self.errors.open(VELOCITY + 1, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
        self.block = Block::new();
    }

    /// Takes the tilt from a specific force (NED as far as the attitude is known) and forgets what was known of it. The first
    /// time the heading counts from where the tool axis (near the vertical: the sum of azimuth and toolface) then is.
    fn align(&mut self, force_ned_m_s2: &Vector3<f32>, config: &AttitudeConfig, earth: &Earth) {
        let norm = libm::sqrtf(force_ned_m_s2.norm_squared());
        self.propagation.q = renormalised(&(to_upright(&(force_ned_m_s2 / norm)) * self.propagation.q));
        if !self.aligned {
            let angles = ToolAngles::of(&matrix(&self.propagation.q));
            let vertical = angles.inclination_rad < config.near_vertical_rad;
            self.turn_heading(-if vertical { angles.magnetic_toolface_rad } else { angles.azimuth_rad });
        }
        let off_gravity = norm / earth.gravity_m_s2 - 1.0;
        let sigma = ALIGNMENT_SIGMA_RAD + off_gravity.abs();
        let heading = self.errors.variance(HEADING);
        for state in 0..HEADING {
            self.errors.open(state, if sigma < PI { sigma * sigma } else { PI * PI });
        }
        self.errors.open(HEADING, heading);
        if heading > LOST_RAD * LOST_RAD && self.heading_blocks > 1 {
            // known before, to be taken from the next field
            self.heading_blocks = 1;
        }
        self.stop(config);
        self.smooth_force_m_s2 = Vector3::new(0.0, 0.0, -norm);
        (self.aligned, self.lost, self.accel_used) = (true, false, true);
    }

    fn turn_heading(&mut self, angle_rad: f32) {
        let turn = Vector3::new(0.0, 0.0, angle_rad);
        self.propagation.correct(&turn);
        let velocity = exp_matrix(&turn) * self.velocity_m_s.push(0.0);
        self.velocity_m_s = velocity.xy();
    }

    fn close_block(&mut self, config: &AttitudeConfig, earth: &Earth) {
        let block = core::mem::replace(&mut self.block, Block::new());
        let force = block.mean_force();
        self.errors.propagate(
            &block.rotation_time,
            if force.is_some() { earth.gravity_m_s2 * block.time_s } else { 0.0 },
            &self.spread(&block, force.is_some(), config),
        );
        self.observe_velocity(force, block.time_s, config);
        if self.rest.detected() {
            self.observe_rest(&block, earth);
        }
        if let Some(field) = block.mean_field() {
            self.mag_used = self.observe_field(&field, &block, config, earth);
        }
        let (mut attitude, bias, velocity) = self.errors.take_correction();
        attitude -= self.earth_rate(earth) * block.time_s;
        self.propagation.correct(&attitude);
        self.bias_rad_s += bias;
        self.velocity_m_s += velocity;
        if !self.errors.is_sound() {
            self.open_all();
            self.stop(config);
        }
        self.check_tilt(force, block.time_s, config, earth);
    }

    fn spread(&self, block: &Block, force_seen: bool, config: &AttitudeConfig) -> Spread {
        let squared_rate = block.squared_rate();
        // what a body-fixed error leaves across the axis of a rotation, which carries it around
        let phase = SCALE_CORRELATION_S * SCALE_CORRELATION_S * squared_rate;
        let across_s = SCALE_CORRELATION_S / (1.0 + phase);
        let scale = config.gyro_scale_sigma * config.gyro_scale_sigma * block.time_s;
        let rate_ned = block.rotation_time * block.angle_rad / (block.time_s * block.time_s);
        let noise = config.gyro_noise_rad_s_rthz * config.gyro_noise_rad_s_rthz * block.time_s;
        let along = rate_ned * rate_ned.transpose() * (scale * (SCALE_CORRELATION_S - across_s));
        let density =
            FORCE_NOISE_M_S2_RTHZ * FORCE_NOISE_M_S2_RTHZ + if force_seen { 0.0 } else { UNSEEN_FORCE_DENSITY };
        Spread {
            attitude: along + Matrix3::from_diagonal_element(noise + scale * across_s * squared_rate),
            bias: config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * block.time_s,
            velocity: density * block.time_s,
        }
    }

    /// The velocity that the force adds up to is an error of the filter, apart from what the probe may really do.
    fn observe_velocity(&mut self, force: Option<Vector3<f32>>, time_s: f32, config: &AttitudeConfig) {
        if let Some(force) = force {
            self.velocity_m_s += force.xy() * time_s;
        }
        let speed = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
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
    }

    /// The earth's rotation, NED, rad/s; zero where the latitude is not known. Its northward part has a direction only once the
    /// heading is known.
    fn earth_rate(&self, earth: &Earth) -> Vector3<f32> {
        let Some(latitude_rad) = earth.latitude_rad else { return Vector3::zeros() };
        let (sine, cosine) = libm::sincosf(latitude_rad);
        let north = if self.heading_blocks > 0 { cosine } else { 0.0 };
        Vector3::new(north, 0.0, -sine) * EARTH_RATE_RAD_S
    }

    /// At rest the mean rate is the bias (and the earth's rate), unless it is one that the bias cannot have.
    fn observe_rest(&mut self, block: &Block, earth: &Earth) {
        let variance = REST_RATE_NOISE_RAD_S_RTHZ * REST_RATE_NOISE_RAD_S_RTHZ / block.time_s;
        let earth_rate = matrix(&self.propagation.q).tr_mul(&self.earth_rate(earth));
        let mean = block.angle_rad / block.time_s - earth_rate;
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
        let timing = config.mag_timing_sigma_s * config.mag_timing_sigma_s * squared_rate;
        let expected = self.errors.variance(HEADING) + direction + 4.0 * timing + tilt;
        if innovation * innovation > HEADING_GATE * HEADING_GATE * expected {
            self.heading_contradiction_s += block.time_s;
            if self.heading_contradiction_s > HEADING_CONTRADICTION_S {
                self.errors.open(HEADING, innovation * innovation);
            }
            return false;
        }
        self.heading_contradiction_s = 0.0;
        let density = 2.0 * (direction * FIELD_CORRELATION_S + timing * TIMING_CORRELATION_S);
        self.errors.observe(HEADING, innovation, density / block.time_s + tilt, Gain::HeadingAndBias);
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
        let f = self.smooth_force_m_s2;
        let norm_squared = f.norm_squared();
        let seen = norm_squared > 0.25 * earth.gravity_m_s2 * earth.gravity_m_s2;
        if self.aligned_s < ALIGNMENT_S && seen {
            self.align(&f, config, earth);
        }
        let upright = f.z < 0.0 && f.z * f.z > 0.25 * norm_squared;
        self.contradiction_s = if seen && !upright { self.contradiction_s + time_s } else { 0.0 };
        if self.contradiction_s > CONTRADICTION_S {
            self.lost = true;
        }
    }
}

/// The shortest rotation that takes a unit vector to straight up, (0, 0, -1).
fn to_upright(up: &Vector3<f32>) -> Quaternion<f32> {
    // between a vector and its image the half-way quaternion is (1 + u.v, u x v), not yet of unit length
    let w = 1.0 - up.z;
    let squared = w * w + up.x * up.x + up.y * up.y;
    if squared > 1e-6 {
        Quaternion::new(w, -up.y, up.x, 0.0) * (1.0 / libm::sqrtf(squared))
    } else {
        Quaternion::new(0.0, 1.0, 0.0, 0.0)
    }
}

impl Default for AttitudeFilter {
    fn default() -> Self {
        Self::new()
    }
}
