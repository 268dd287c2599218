//! Error of the gyro's scale factors and couplings as a state: a probe carried by hand turns in every direction, so
//! that gravity and field show it within seconds, long before an identified model flies.

#![allow(clippy::indexing_slicing)] // Elements of fixed-size matrices, counted by loops.

use super::{
    error_state::SCALES,
    settings::Settings,
    state::{GyroScale, State},
};

/// Deviations of an uncalibrated gyro: scale factors, couplings (`IdentificationConfig::prior_sigma_diagonal` and
/// `prior_sigma_off_diagonal`, defaults).
const UNCALIBRATED: [f32; 2] = [0.06, 0.03];
/// Chi-square of nine degrees of freedom, exceeded once in twenty. Elements of which nothing is known yet are zero, so
/// that chance exceeds it more rarely.
const CONTRADICTED: f32 = 16.92;

/// Deviation of the constant part of one element's error. The rest that a data sheet allows changes with the motion
/// (temperature, nonlinearity, time stamps) and is noise. A data sheet does not state the shares: half of the variance
/// each is assumed.
pub(super) fn constant_part(gyro_scale_sigma: f32) -> f32 {
    gyro_scale_sigma * core::f32::consts::FRAC_1_SQRT_2
}

/// Starts to estimate the scale of a gyro of which no more is known than its data sheet.
pub(super) fn start(state: &mut State, settings: &Settings) {
    let sigma = constant_part(settings.config.gyro_scale_sigma);
    state.errors.estimate_scale(&[sigma; SCALES]);
    state.scale = GyroScale { by_data_sheet: true, ..GyroScale::ZERO };
}

/// Starts the scale's estimate anew under a gyro model whose P is known with these deviations.
pub(super) fn identified(state: &mut State, deviations: &[f32; SCALES]) {
    state.errors.estimate_scale(deviations);
    state.scale = GyroScale { is_identified: true, ..GyroScale::ZERO };
}

/// Replaces the data sheet's prior by that of an uncalibrated gyro once the estimate contradicts it. Earlier
/// observations count as if the wider prior had held from the start.
pub(super) fn check_prior(state: &mut State, settings: &Settings) {
    let sigma = constant_part(settings.config.gyro_scale_sigma);
    let square = state.scale.errors.norm_squared() / (sigma * sigma);
    // A NaN contradicts nothing.
    if !(state.scale.by_data_sheet && square > CONTRADICTED) {
        return;
    }
    state.scale.by_data_sheet = false;
    for k in 0..SCALES {
        let (row, column) = (k / 3, k % 3);
        let wide = if row == column { UNCALIBRATED[0] } else { UNCALIBRATED[1] };
        if wide > sigma {
            // A negative variance takes out what the data sheet's prior says beyond the wider one.
            let variance = -1.0 / (1.0 / (sigma * sigma) - 1.0 / (wide * wide));
            state.errors.update_scale(k, -state.scale.errors[(row, column)], variance);
        }
    }
    state.correct(&settings.config);
}
