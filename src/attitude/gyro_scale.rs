//! Error of the gyro's scale factors and couplings as a state: gravity and field show it within seconds of turning,
//! long before an identified model flies.

use super::{
    error_state::SCALES,
    settings::Settings,
    state::{GyroScale, State},
};

/// Deviations of an uncalibrated gyro: scale factors, couplings (`IdentificationConfig::prior_sigma_diagonal` and
/// `prior_sigma_off_diagonal`, defaults).
const UNCALIBRATED: [f32; 2] = [0.06, 0.03];
/// Log Bayes factor from which on an uncalibrated gyro's prior takes the place of the data sheet's: a factor of twenty,
/// which a gyro of that data sheet reaches once in twenty at most, however often it is asked (Ville's inequality).
const CONTRADICTED: f32 = 3.0;
/// Error beyond which no gyro is off: more than eight deviations of an uncalibrated one.
const LARGEST: f32 = 0.5;
/// Time between two comparisons of the priors, seconds.
const COMPARED_EVERY_S: f32 = 0.5;

/// Deviation of the constant part of one element's error. The rest that a data sheet allows changes with the motion
/// (temperature, nonlinearity, time stamps) and is noise. A data sheet does not state the shares: half of the variance
/// each is assumed.
pub(super) fn constant_part(gyro_scale_sigma: f32) -> f32 {
    gyro_scale_sigma * core::f32::consts::FRAC_1_SQRT_2
}

/// Starts to estimate the scale of a gyro of which no more is known than its data sheet. Returns the deviation of the
/// part of the scale's error that stays noise.
pub(super) fn start(state: &mut State, settings: &Settings) -> f32 {
    let constant = constant_part(settings.config.gyro_scale_sigma);
    state.errors.estimate_scale(&[constant; SCALES]);
    state.scale = GyroScale { by_data_sheet: true, ..GyroScale::ZERO };
    // The other half of the variance.
    constant
}

/// Forgets what was found of a gyro's scale of which no model is known: it was learnt from vectors that were wrong.
// Inlined at its two places it would take a quarter of a kilobyte of flash.
#[inline(never)]
pub(super) fn start_over(state: &mut State, settings: &Settings) {
    if state.errors.estimates_scale() && !state.scale.is_identified {
        start(state, settings);
    }
}

/// Starts over where an error is found that no gyro has: then a vector is wrong.
pub(super) fn check(state: &mut State, settings: &Settings) {
    // A NaN is none, either.
    let is_plausible = state.scale.errors.iter().all(|error| libm::fabsf(*error) < LARGEST);
    if !is_plausible {
        state.reset_bias(&settings.config);
        start_over(state, settings);
    }
}

/// Ends the estimate of the scale that flew with another gyro model. Under this one, whose P is known with these
/// deviations, it starts anew by hand. On a drill string, which rotates about one axis, what is left of the scale's
/// error is noise and, in a sustained rotation, a bias. Returns the deviation of the part that is noise.
pub(super) fn identified(state: &mut State, deviations: &[f32; SCALES], settings: &Settings) -> f32 {
    if settings.goes_round {
        state.errors.leave_scale();
        state.scale = GyroScale::ZERO;
        return settings.config.gyro_scale_sigma;
    }
    state.errors.estimate_scale(deviations);
    state.scale = GyroScale { is_identified: true, ..GyroScale::ZERO };
    constant_part(settings.config.gyro_scale_sigma)
}

/// Replaces the data sheet's prior by that of an uncalibrated gyro once that is twenty times as
/// probable. Earlier observations count as if the wider prior had held from the start.
// The copy of the covariance would lie on the stack of the whole step.
#[inline(never)]
pub(super) fn compare_priors(state: &mut State, time_s: f32, settings: &Settings) {
    if !state.scale.by_data_sheet {
        return;
    }
    state.scale.uncompared_s += time_s;
    if state.scale.uncompared_s < COMPARED_EVERY_S {
        return;
    }
    state.scale.uncompared_s = 0.0;
    let mut widened = state.errors;
    let sigma = constant_part(settings.config.gyro_scale_sigma);
    let log_bayes_factor = widened.widen_scale(&state.scale.errors, sigma, UNCALIBRATED);
    // A NaN shows nothing.
    if log_bayes_factor > CONTRADICTED && widened.is_sound() {
        state.scale.by_data_sheet = false;
        state.errors = widened;
        state.correct(&settings.config);
    }
}
