//! Tilt: alignment by a force, updates by gravity through velocity, and the checks of both.

#![allow(clippy::indexing_slicing)] // Axes of fixed-size vectors, counted by loops.

use super::{
    consistency::Consistency,
    error_state::{Gain, HEADING, VELOCITY},
    filter_step::FilterStep,
    gyro_scale,
    heading::Heading,
    rest::RestTracker,
    settings::Settings,
    state::State,
    toolface::ToolAngles,
};
use crate::{
    rotation::{matrix, renormalised},
    statistics::chi_square::OF_TWO_IN_A_THOUSAND,
};
use core::f32::consts::PI;
use nalgebra::{Quaternion, Vector2, Vector3};

/// Uncertainty of a tilt taken from a force of gravity's norm, radians: 0.1 g of acceleration, as of a hand.
const ALIGNMENT_SIGMA_RAD: f32 = 0.1;
/// Standard deviation of a smoothed force's direction, radians: half a m/s^2 of acceleration.
pub(super) const FORCE_SIGMA_RAD: f32 = 0.05;
/// Correlation time of the probe's velocity, seconds: one radian of phase of a hand's 0.5 Hz swing.
const VELOCITY_CORRELATION_S: f32 = 0.3;
/// Least mean square of the force, relative to gravity's, with which the force is used. Accelerations that average out
/// only add to it; free fall or a dead axis takes from it. An accelerometer whose norm is a tenth low, as without a
/// calibration, passes.
const LEAST_MEAN_SQUARE_FORCE: f32 = 0.8;
/// Averaging time of the force's mean square, seconds: vibration of 1 g at 10 Hz then changes it by some per cent.
const MEAN_SQUARE_S: f32 = 1.0;
/// Gate of the velocity, in sigmas, beyond which the observation weighs less: exceeded by chance once in 400.
const VELOCITY_GATE: f32 = 3.0;
/// Time over which the first tilt averages the force, seconds: a quarter of the time that a start may take; a shock
/// takes hundredths of a second.
const ALIGNMENT_S: f32 = 0.5;
/// Longest silence of the gyro that a first tilt averages over, seconds: a filter step. A string that turns at 6 rad/s
/// goes on by 0.3 rad in it, up to which the linear equations hold (`LOST_RAD`).
const SHORT_SILENCE_S: f32 = 0.05;
/// Smoothing of the force that is checked against the attitude, and the time for which it must contradict,
/// seconds: a hand's motion averages out over its swing.
const CONTRADICTION_S: f32 = 2.0;
/// Smoothing of the force that may lean, seconds: as the first tilt's.
const LEAN_S: f32 = ALIGNMENT_S;
/// Time without gravity after which the field no longer corrects the bias, seconds: with 0.4 (m/s^2)^2/Hz of unread
/// acceleration the speed is then less certain than the assumed half metre a second.
const UNSEEN_FORCE_S: f32 = 1.0;

/// Tilt as the specific force gives it or contradicts it.
pub(super) struct Tilt {
    /// True after the first alignment.
    pub aligned: bool,
    /// True if gravity and field must give the attitude anew.
    pub lost: bool,
    /// True if the last step's force was used in full.
    pub force_used: bool,
    /// Angle between the tilt and a mean force that is not used, about north and about east, radians.
    pub doubt_rad: Vector2<f32>,
    smooth_force_m_s2: Vector3<f32>,
    /// Horizontal force smoothed over [`LEAN_S`], north and east, m/s^2.
    lean_m_s2: Vector2<f32>,
    /// Time for which there has been a doubt, seconds.
    doubted_s: f32,
    /// Mean square of the force over about a second, relative to gravity's.
    mean_square_force: f32,
    /// Time since the tilt was last taken from the force, at most [`CONTRADICTION_S`], seconds.
    aligned_s: f32,
    contradiction_s: f32,
    velocity_contradiction_s: f32,
    /// Time since a specific force was used, seconds.
    unseen_s: f32,
}

impl Tilt {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self {
            aligned: false,
            lost: false,
            force_used: false,
            doubt_rad: Vector2::new(0.0, 0.0),
            smooth_force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            lean_m_s2: Vector2::new(0.0, 0.0),
            doubted_s: 0.0,
            mean_square_force: 0.0,
            aligned_s: 0.0,
            contradiction_s: 0.0,
            velocity_contradiction_s: 0.0,
            unseen_s: 0.0,
        }
    }

    /// Creates the tilt of a filter that has not been aligned, with a mean force of gravity's norm.
    pub const fn new() -> Self {
        Self { mean_square_force: 1.0, ..Self::zero() }
    }

    /// Returns true once the tilt has averaged the force for long enough.
    pub const fn is_settled(&self) -> bool {
        self.aligned_s >= ALIGNMENT_S
    }

    /// Has the next force give a tilt anew that is still averaged, after `silent_s` seconds without a rate: the mean
    /// would span a turn that was not seen.
    pub const fn interrupt(&mut self, silent_s: f32) {
        self.lost = self.lost || (silent_s > SHORT_SILENCE_S && self.aligned && !self.is_settled());
    }

    /// Returns true while gravity bounds the bias that a field may correct.
    pub const fn force_seen_lately(&self) -> bool {
        self.unseen_s < UNSEEN_FORCE_S
    }

    /// Returns true if there has been a doubt for so long that the field was read at a wrong tilt, too; a shock passes.
    pub const fn has_long_been_doubted(&self) -> bool {
        self.doubted_s > LEAN_S
    }

    /// Notes if a step had a usable force.
    pub fn note_force(&mut self, seen: bool, time_s: f32) {
        self.unseen_s = if seen { 0.0 } else { self.unseen_s + time_s };
    }

    /// Aligns the attitude to a single reading of the specific force. That reading may have met a shock, so the mean
    /// force of the seconds after the alignment is averaged from here on.
    pub fn align_anew(&mut self, state: &mut State, heading: &mut Heading, force: &Vector3<f32>, settings: &Settings) {
        self.align(state, heading, force, settings);
        state.consistency = Consistency::new();
        (self.aligned_s, self.contradiction_s) = (0.0, 0.0);
        self.believe();
    }

    /// Ends the doubt: the tilt has been taken anew.
    pub fn believe(&mut self) {
        (self.doubt_rad, self.lean_m_s2, self.doubted_s) = (Vector2::zeros(), Vector2::zeros(), 0.0);
    }

    /// Takes the tilt from a specific force (NED as far as the attitude is known) and resets its uncertainty.
    /// At the first alignment the heading counts from the tool axis; near the vertical, from the sum of azimuth
    /// and toolface.
    fn align(&mut self, state: &mut State, heading: &mut Heading, force_ned_m_s2: &Vector3<f32>, settings: &Settings) {
        let config = &settings.config;
        let norm = libm::sqrtf(force_ned_m_s2.norm_squared());
        state.propagation.turn(&renormalised(&to_upright(&(force_ned_m_s2 / norm))));
        if !self.aligned {
            let angles = ToolAngles::of(&matrix(&state.propagation.q));
            let vertical = angles.inclination_rad < config.near_vertical_rad;
            state.turn_heading(-if vertical { angles.magnetic_toolface_rad } else { angles.azimuth_rad });
        }
        state.refresh_rotation();
        let off_gravity = norm / settings.earth.gravity_m_s2 - 1.0;
        let sigma = ALIGNMENT_SIGMA_RAD + off_gravity.abs();
        // A third of the shaking acts along each direction.
        let shaken = if self.mean_square_force > 1.0 { (self.mean_square_force - 1.0) / 3.0 } else { 0.0 };
        let variance = sigma * sigma + shaken;
        let heading_variance = state.errors.variance(HEADING);
        for tilt in 0..HEADING {
            state.errors.reset(tilt, if variance < PI * PI { variance } else { PI * PI });
        }
        state.errors.reset(HEADING, heading_variance);
        heading.realign(heading_variance);
        state.reset_velocity(config);
        self.smooth_force_m_s2 = Vector3::new(0.0, 0.0, -norm);
        (self.aligned, self.lost, self.force_used) = (true, false, true);
    }

    /// Updates by the integrated force: velocity beyond the probe's plausible speed is an error of the filter.
    pub fn update_velocity(
        &mut self,
        state: &mut State,
        force: Option<Vector3<f32>>,
        rest: &RestTracker,
        time_s: f32,
        settings: &Settings,
    ) {
        if let Some(force) = force {
            state.velocity_m_s += force.xy() * time_s;
        }
        let config = &settings.config;
        let moving = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
        let resting = rest.square_speed();
        let speed = if rest.detected() && resting < moving { resting } else { moving };
        self.force_used = force.is_some();
        for k in 0..2 {
            let velocity = state.velocity_m_s[k];
            let squared = velocity * velocity;
            let expected = state.errors.variance(VELOCITY + k) + speed;
            if force.is_some() {
                state.consistency.note_velocity(squared / expected, time_s);
            }
            let expected = VELOCITY_GATE * VELOCITY_GATE * expected;
            let mut variance = speed * 2.0 * VELOCITY_CORRELATION_S / time_s;
            if squared > expected {
                variance *= squared / expected;
                self.force_used = false;
            }
            state.errors.update(VELOCITY + k, -velocity, variance, Gain::Every);
        }
        let contradicted = force.is_some() && !self.force_used;
        self.velocity_contradiction_s = if contradicted { self.velocity_contradiction_s + time_s } else { 0.0 };
        if self.velocity_contradiction_s > CONTRADICTION_S {
            // No such speed lasts: the tilt, or the force, has a larger error than the filter assumes.
            self.velocity_contradiction_s = 0.0;
            state.velocity_m_s = Vector2::zeros();
            for k in 0..2 {
                state.errors.reset(VELOCITY + k, speed);
                state.errors.inflate(k, ALIGNMENT_SIGMA_RAD * ALIGNMENT_SIGMA_RAD, PI * PI);
            }
            state.consistency.note_added([1.0, 0.0]);
            state.reset_bias(config);
            gyro_scale::start_over(state, settings);
        }
    }

    /// Returns true if the force can be gravity plus acceleration: large enough, and not upside down while the field
    /// agrees with the attitude.
    pub fn force_is_sound(&mut self, step: &FilterStep, field_agrees: bool, gravity_m_s2: f32) -> bool {
        let Some(square) = step.mean_square_force() else { return true };
        let weight = step.time_s / (MEAN_SQUARE_S + step.time_s);
        let gravity = gravity_m_s2 * gravity_m_s2;
        // Capped, so that a shock hides a missing axis for seconds at most.
        let share = if square < 16.0 * gravity { square / gravity } else { 16.0 };
        self.mean_square_force += (share - self.mean_square_force) * weight;
        let overturned = field_agrees && !upright(&self.smooth_force_m_s2);
        self.mean_square_force > LEAST_MEAN_SQUARE_FORCE && !overturned
    }

    /// Checks the tilt by the mean force over seconds, which points up whatever the probe does. At first the
    /// tilt is taken from it, since a single reading may have met a shock. Later a mean force more than 60 deg
    /// off means that the linear filter is lost (upside down it would never recover), and the tilt is taken
    /// again.
    pub fn check(
        &mut self,
        state: &mut State,
        heading: &mut Heading,
        force: Option<Vector3<f32>>,
        density: f32,
        time_s: f32,
        settings: &Settings,
    ) {
        let Some(force) = force else { return };
        let gravity_m_s2 = settings.earth.gravity_m_s2;
        self.aligned_s += if self.aligned_s < CONTRADICTION_S { time_s } else { 0.0 };
        self.smooth_force_m_s2 += (force - self.smooth_force_m_s2) * (time_s / (self.aligned_s + time_s));
        let f = self.smooth_force_m_s2;
        let seen = f.norm_squared() > 0.25 * gravity_m_s2 * gravity_m_s2;
        if !self.is_settled() && seen {
            self.align(state, heading, &f, settings);
        }
        let overturned = !upright(&f);
        // A force that is not used, or leans, makes the tilt uncertain by its angle, about north and about east.
        self.lean_m_s2 += (force.xy() - self.lean_m_s2) * (time_s / (LEAN_S + time_s));
        let leaning = if self.force_used { self.leaning(density, settings) } else { f.xy() };
        let per_gravity = if seen { 1.0 / gravity_m_s2 } else { 0.0 };
        let doubt = Vector2::new(leaning.y, leaning.x) * per_gravity;
        // A lean near its gate comes and goes with the shaking, and the error that it shows does not: a doubt that is
        // no chance, because it has lasted, fades as slowly as the mean force forgets.
        let lasts = settings.goes_round && self.doubted_s > CONTRADICTION_S;
        self.doubt_rad *= if lasts { CONTRADICTION_S / (CONTRADICTION_S + time_s) } else { 0.0 };
        if doubt.norm_squared() > self.doubt_rad.norm_squared() {
            self.doubt_rad = doubt;
        }
        let constant = settings.config.accel_sigma_m_s2 * per_gravity;
        let is_doubted = self.doubt_rad.norm_squared() > constant * constant;
        self.doubted_s = if is_doubted { self.doubted_s + time_s } else { 0.0 };
        let contradicted = seen && overturned && !heading.agrees();
        self.contradiction_s = if contradicted { self.contradiction_s + time_s } else { 0.0 };
        if self.contradiction_s > CONTRADICTION_S {
            self.lost = true;
            state.reset_bias(&settings.config);
            gyro_scale::start_over(state, settings);
            // The shortest turn to upright leaves the heading anywhere.
            state.errors.reset(HEADING, PI * PI);
            state.consistency.note_added([1.0; 2]);
        }
    }

    /// Returns true if the attitude would contradict the smoothed force after this turn (NED), and more than before it:
    /// `variance` is that of the turned tilt, rad^2.
    pub fn contradicts(&self, by: &Quaternion<f32>, variance: f32) -> bool {
        let force = &self.smooth_force_m_s2;
        let (before, after) = (force.xy().norm_squared(), (matrix(by) * force).xy().norm_squared());
        let tolerance = OF_TWO_IN_A_THOUSAND * (variance + FORCE_SIGMA_RAD * FORCE_SIGMA_RAD);
        after > before + tolerance * force.norm_squared()
    }

    /// Horizontal part, m/s^2, of a smoothed force that is further from the vertical than shaking of this spectral
    /// density ((m/s^2)^2/Hz) and the accelerometer's constant error explain; of the two means the one further off,
    /// zero if neither is. On a drill string no acceleration lasts for half a second, so the tilt is off by this angle.
    fn leaning(&self, density: f32, settings: &Settings) -> Vector2<f32> {
        let mut furthest = Vector2::zeros();
        if !settings.goes_round || !self.is_settled() {
            return furthest;
        }
        let constant = settings.config.accel_sigma_m_s2;
        for (mean, smoothing_s) in [(self.lean_m_s2, LEAN_S), (self.smooth_force_m_s2.xy(), CONTRADICTION_S)] {
            let variance = 0.5 * (density / smoothing_s + constant * constant);
            let square = mean.norm_squared();
            if square > OF_TWO_IN_A_THOUSAND * variance && square > furthest.norm_squared() {
                furthest = mean;
            }
        }
        furthest
    }
}

/// Returns true if a mean force, NED, points up within 60 deg.
fn upright(force: &Vector3<f32>) -> bool {
    force.z < 0.0 && force.z * force.z > 0.25 * force.norm_squared()
}

/// Shortest rotation of a unit vector to straight up, (0, 0, -1).
fn to_upright(up: &Vector3<f32>) -> Quaternion<f32> {
    // Half-way quaternion between a vector u and its image v: (1 + u.v, u x v), not yet normalised.
    let w = 1.0 - up.z;
    let squared = w * w + up.x * up.x + up.y * up.y;
    if squared > 1e-6 {
        Quaternion::new(w, -up.y, up.x, 0.0) * (1.0 / libm::sqrtf(squared))
    } else {
        Quaternion::new(0.0, 1.0, 0.0, 0.0)
    }
}
