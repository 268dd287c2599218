//! State of the attitude filter: attitude, bias and velocity, with their covariance.

#![allow(clippy::indexing_slicing)] // Axes of fixed-size vectors, counted by loops.

use super::{
    consistency::Consistency,
    error_state::{BIAS, ErrorState, Gain, HEADING, STATES, VELOCITY},
    filter_step::FilterStep,
    propagation::Propagation,
    rest,
};
use crate::{
    config::AttitudeConfig,
    rotation::{IDENTITY, exp_matrix, matrix},
};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Density of the mean rate about the bias at rest, rad/s per root hertz: three times the gyro's noise, for slow motion
/// that still counts as rest.
const REST_RATE_NOISE_RAD_S_RTHZ: f32 = 5e-4;
/// Gate of the mean rate at rest as a bias, in sigmas: exceeded by chance once in 400.
const REST_GATE: f32 = 3.0;

/// Estimated error of the compensated gyro: the true rate is (1 + D) times the compensated one.
pub(super) struct GyroScale {
    /// D, dimensionless.
    pub errors: Matrix3<f32>,
    /// True while the prior of D is a data sheet's.
    pub by_data_sheet: bool,
    /// Time since that prior was compared with a wider one, seconds.
    pub uncompared_s: f32,
    /// True under an identified gyro model, whose deviations are known.
    pub is_identified: bool,
}

impl GyroScale {
    /// No error, for a static.
    pub const ZERO: Self = Self {
        errors: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        by_data_sheet: false,
        uncompared_s: 0.0,
        is_identified: false,
    };
}

/// Estimate of the attitude filter.
pub(super) struct State {
    /// Attitude as a quaternion, body to NED.
    pub propagation: Propagation,
    /// Attitude as a matrix, body to NED.
    pub rotation: Matrix3<f32>,
    /// Residual gyro bias, body frame, rad/s.
    pub bias_rad_s: Vector3<f32>,
    /// Horizontal velocity, integrated from the force, north and east, m/s.
    pub velocity_m_s: Vector2<f32>,
    pub errors: ErrorState,
    pub scale: GyroScale,
    pub consistency: Consistency,
}

impl State {
    /// All zero, for a static.
    pub const fn zero() -> Self {
        Self {
            propagation: Propagation::new(),
            rotation: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            bias_rad_s: Vector3::new(0.0, 0.0, 0.0),
            velocity_m_s: Vector2::new(0.0, 0.0),
            errors: ErrorState::new(),
            scale: GyroScale::ZERO,
            consistency: Consistency::ZERO,
        }
    }

    /// Creates a state of which nothing is known.
    pub fn new(config: &AttitudeConfig) -> Self {
        let mut state = Self { rotation: Matrix3::identity(), consistency: Consistency::new(), ..Self::zero() };
        state.propagation.q = IDENTITY;
        state.reset_errors(config);
        state
    }

    /// Advances the attitude by the `dt_s` seconds that end now, at their mean [`State::corrected`] rate.
    pub fn advance(&mut self, dt_s: f32, rate_rad_s: &Vector3<f32>) {
        self.propagation.step(dt_s, rate_rad_s);
        self.refresh_rotation();
    }

    /// Body rate, rad/s: a compensated rate, corrected by the estimated bias and scale error.
    pub fn corrected(&self, rate_rad_s: &Vector3<f32>) -> Vector3<f32> {
        rate_rad_s + self.scale.errors * rate_rad_s - self.bias_rad_s
    }

    pub fn refresh_rotation(&mut self) {
        self.rotation = matrix(&self.propagation.q);
    }

    /// Rotates attitude and velocity about the vertical; the matrix is left to [`State::refresh_rotation`].
    pub fn turn_heading(&mut self, angle_rad: f32) {
        let turn = Vector3::new(0.0, 0.0, angle_rad);
        self.propagation.correct(&turn);
        let velocity = exp_matrix(&turn) * self.velocity_m_s.push(0.0);
        self.velocity_m_s = velocity.xy();
    }

    /// Applies the corrections that updates have collected. A covariance that is not sound is reset instead, with the
    /// velocity: then it returns false, and the scale is no longer estimated.
    pub fn correct(&mut self, config: &AttitudeConfig) -> bool {
        let is_sound = self.errors.is_sound();
        if is_sound {
            let (attitude, bias, velocity, scale) = self.errors.take_correction();
            self.propagation.correct(&attitude);
            self.bias_rad_s += bias;
            self.velocity_m_s += velocity;
            self.scale.errors += scale;
        } else {
            self.reset_errors(config);
            self.reset_velocity(config);
        }
        is_sound
    }

    fn reset_errors(&mut self, config: &AttitudeConfig) {
        let bias = config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s;
        let speed = config.velocity_sigma_m_s * config.velocity_sigma_m_s;
        self.errors = ErrorState::new();
        self.scale = GyroScale::ZERO;
        self.consistency = Consistency::new();
        for state in 0..STATES {
            let variance = match state {
                0..BIAS => PI * PI,
                BIAS..VELOCITY => bias,
                _ => speed,
            };
            self.errors.reset(state, variance);
        }
    }

    // Inlined at its places it would take flash that the image has not.
    #[inline(never)]
    pub fn reset_bias(&mut self, config: &AttitudeConfig) {
        for k in 0..3 {
            self.errors.reset(BIAS + k, config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s);
        }
    }

    pub fn reset_velocity(&mut self, config: &AttitudeConfig) {
        self.velocity_m_s = Vector2::zeros();
        self.errors.reset(VELOCITY, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
        self.errors.reset(VELOCITY + 1, config.velocity_sigma_m_s * config.velocity_sigma_m_s);
    }

    /// Inflates the attitude by a squared angle about each axis, rad^2.
    pub fn inflate_attitude(&mut self, square: f32) {
        let [north, east, heading] = [0, 1, HEADING].map(|k| square / (self.errors.variance(k) + square));
        self.consistency.note_added([0.5 * (north + east), heading]);
        for k in 0..BIAS {
            self.errors.inflate(k, square, PI * PI);
        }
    }

    /// Updates the bias by the mean rate at rest, unless that rate is implausible as a bias. A bias of twice
    /// the largest rate of a rest is wrong, and as uncertain as it is large.
    pub fn update_at_rest(&mut self, step: &FilterStep) {
        let variance = REST_RATE_NOISE_RAD_S_RTHZ * REST_RATE_NOISE_RAD_S_RTHZ / step.time_s;
        let mean = step.angle_rad / step.time_s;
        let gate = REST_GATE * REST_GATE;
        let square = self.bias_rad_s.norm_squared();
        if square > 4.0 * rest::RATE_RAD_S * rest::RATE_RAD_S {
            for k in 0..3 {
                self.errors.reset(BIAS + k, square);
            }
        }
        let possible = (0..3).all(|k| mean[k] * mean[k] < gate * (self.errors.variance(BIAS + k) + variance));
        if possible {
            for k in 0..3 {
                self.errors.update(BIAS + k, mean[k], variance, Gain::Every);
            }
        }
    }
}
