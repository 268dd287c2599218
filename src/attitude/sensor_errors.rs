//! Errors of the sensors as the attitude filter assumes them, changed in flight by another gyro model or a known delay.

#![allow(clippy::indexing_slicing)] // Axes of fixed-size vectors, counted by loops.

use super::{
    error_state::{BIAS, SCALES},
    gyro_scale,
    heading::Heading,
    settings::Settings,
    state::State,
};
use crate::{
    compensation::GyroModel, config::AttitudeConfig, estimator::turned_back, statistics::chi_square::IN_TWENTY,
};
use nalgebra::{Matrix3, Vector3};

/// Least scale error after compensation: the gyro's nonlinearity, 0.1 % (MPU-9250 PS section 3.1).
const LEAST_SCALE: f32 = 1e-3;
/// Least bias error after compensation, rad/s: the gyro's sensitivity to 1 g, 0.1 deg/s (MPU-6000 PS section
/// 6.1).
const LEAST_BIAS_RAD_S: f32 = 1.75e-3;
/// Least uncertainty of a known delay, seconds (the default of `SurveyErrors::mag_timing_s`).
const LEAST_TIMING_S: f32 = 1e-3;

/// Deviations of the sensors' errors after compensation.
pub(super) struct SensorErrors {
    /// Deviation of the gyro's scale factors and couplings.
    pub scale_sigma: f32,
    /// Variance of the magnetometer's delay against the gyro, s^2.
    pub mag_timing_variance_s2: f32,
    /// Variance on an axis of what was taken out of the field, effects and a magnet's offset, microtesla^2.
    pub mag_offset_variance_ut2: f32,
    /// Variance of the gyro's delay, in squared sample periods.
    pub gyro_timing_variance: f32,
}

impl SensorErrors {
    /// All zero, for a static.
    pub const ZERO: Self =
        Self { scale_sigma: 0.0, mag_timing_variance_s2: 0.0, mag_offset_variance_ut2: 0.0, gyro_timing_variance: 0.0 };

    /// Creates the configured errors, with a known delay of the gyro and an unknown one of the magnetometer.
    pub fn new(config: &AttitudeConfig) -> Self {
        let mut errors = Self { scale_sigma: config.gyro_scale_sigma, ..Self::ZERO };
        errors.set_mag_delay(None, config);
        errors
    }

    /// Sets the deviation of the magnetometer's delay, seconds, after it is taken out; `None`: the delay is not known.
    pub fn set_mag_delay(&mut self, sigma_s: Option<f32>, config: &AttitudeConfig) {
        self.mag_timing_variance_s2 = match sigma_s {
            Some(sigma_s) => sigma_s * sigma_s + LEAST_TIMING_S * LEAST_TIMING_S,
            None => config.mag_timing_sigma_s * config.mag_timing_sigma_s,
        };
    }

    /// Swaps the gyro model, see [`AttitudeFilter::model_changed`](super::AttitudeFilter::model_changed), at the mean
    /// rate of a sustained rotation or at rest. Returns true if the former model was wrong.
    pub fn change_model(
        &mut self,
        state: &mut State,
        heading: &mut Heading,
        [old, new]: [&GyroModel; 2],
        sigma: &[f32; 12],
        rate_rad_s: &Vector3<f32>,
        settings: &Settings,
    ) -> bool {
        let config = &settings.config;
        // The error of the rate, as far as it has been learnt, stays valid under the new model, at the rate at which it
        // was learnt: in a steady rotation a bias and a coupling cannot be told apart, and change against each other.
        let at = if settings.goes_round { *rate_rad_s } else { Vector3::zeros() };
        // With the former P goes what was found of its scale.
        let of_scale = if old.p == new.p { Vector3::zeros() } else { state.scale.errors * at };
        let raw = turned_back(old, &(at - of_scale)) + Vector3::from(old.b_rad_s);
        state.bias_rad_s += new.p_matrix() * (raw - Vector3::from(new.b_rad_s)) - at;
        if old.p == new.p {
            return false;
        }
        let (change, is_other) = self.surprise(state, &old.p_matrix(), &new.p_matrix());
        let mut deviations = [0.0; SCALES];
        deviations.iter_mut().zip(sigma).for_each(|(to, sigma)| *to = between(*sigma, LEAST_SCALE, 1.0));
        let was_estimated = state.errors.estimates_scale();
        let white = gyro_scale::identified(state, &deviations, settings);
        if !is_other {
            // P changes as the filter expected: the former model was not wrong by more than that.
            if settings.goes_round {
                if was_estimated {
                    self.scale_sigma = white;
                }
                Self::adopt(state, &at, sigma, config.gyro_bias_sigma_rad_s);
            }
            return false;
        }
        state.bias_rad_s = Vector3::zeros();
        heading.reset(state);
        // The former model turned the attitude wrongly by this share of every radian.
        state.inflate_attitude(change);
        let mean_square = sigma.iter().take(9).fold(0.0, |sum, s| sum + s * s) / 9.0;
        self.scale_sigma = between(libm::sqrtf(mean_square), LEAST_SCALE, white);
        for (k, sigma) in sigma.iter().skip(9).enumerate() {
            let sigma = between(*sigma, LEAST_BIAS_RAD_S, config.gyro_bias_sigma_rad_s);
            state.errors.reset(BIAS + k, sigma * sigma);
        }
        true
    }

    /// Drops the residual bias on each axis on which the new model's rate is more certain than it, at this mean rate
    /// and with the change over temperature, `bias_sigma_rad_s`, that no model knows.
    fn adopt(state: &mut State, rate_rad_s: &Vector3<f32>, sigma: &[f32; 12], bias_sigma_rad_s: f32) {
        let variances = sigma.map(|sigma| sigma * sigma);
        let squares = rate_rad_s.component_mul(rate_rad_s);
        for axis in 0..3 {
            let of_p = (0..3).fold(0.0, |sum, k| sum + variances[3 * axis + k] * squares[k]);
            let variance = of_p + variances[9 + axis] + bias_sigma_rad_s * bias_sigma_rad_s;
            if variance < state.errors.variance(BIAS + axis) {
                state.bias_rad_s[axis] = 0.0;
                state.errors.reset(BIAS + axis, variance);
            }
        }
    }

    /// Largest square by which a column of P differs from the former one, and from that one with the scale's errors
    /// that the filter has found: the smaller of both. Whether it is improbable by the gyro's stated scale error and by
    /// the filter's own deviations.
    fn surprise(&self, state: &State, old: &Matrix3<f32>, new: &Matrix3<f32>) -> (f32, bool) {
        let change = new - old;
        let unexpected = change - state.scale.errors * old;
        let stated = self.scale_sigma * self.scale_sigma;
        let (mut most, mut is_other) = (0.0, false);
        for (axis, (one, other)) in change.column_iter().zip(unexpected.column_iter()).enumerate() {
            let (one, other) = (one.norm_squared(), other.norm_squared());
            let square = if other < one { other } else { one };
            // A column of P has three elements.
            let found = state.errors.scale_variance_of_axis(axis) / 3.0;
            is_other |= square > IN_TWENTY * if found > stated { found } else { stated };
            most = if square > most { square } else { most };
        }
        (most, is_other)
    }
}

/// Limits a number; a NaN becomes the least.
fn between(x: f32, least: f32, most: f32) -> f32 {
    if x > most {
        most
    } else if x > least {
        x
    } else {
        least
    }
}
