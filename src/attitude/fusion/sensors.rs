//! What becomes known of the sensors while the filter runs: another gyro model, other effects, a delay.

use super::{AttitudeFilter, BIAS, HEADING, PI};
use crate::compensation::GyroModel;
use nalgebra::Vector3;

/// What no twelve parameters take away of a gyro's scale: its nonlinearity, 0.1 % (MPU-9250 PS section 3.1).
const LEAST_SCALE: f32 = 1e-3;
/// What they do not take away of its bias: its sensitivity to 1 g, 0.1 deg/s (MPU-6000 PS section 6.1), rad/s.
const LEAST_BIAS_RAD_S: f32 = 1.75e-3;
/// A delay is never known better than this, seconds (as the default of `SurveyErrors::mag_timing_s`).
const LEAST_TIMING_S: f32 = 1e-3;
/// A P that changes by more than so many deviations of what was thought of it (95 %) was another one.
const DOUBTED: f32 = 2.0;

impl AttitudeFilter {
    /// The gyro model has been swapped. The attitude does not move, and as long as P stays neither does the total bias: what the new
    /// model takes off more or less goes into the residual one, whose deviation is kept, so that the filter alone owns the bias. A
    /// residual bias beside another P was in part P's error: it is dropped, and the deviations of the new model (P row-major, then b, rad/s)
    /// take the place of the configured ones where they are smaller.
    pub fn model_changed(&mut self, old: &GyroModel, new: &GyroModel, sigma: &[f32; 12]) {
        let Some((config, _)) = self.settings() else { return };
        // What was learnt of the bias that flew holds for the one that flies.
        self.bias_rad_s += new.p_matrix() * (Vector3::from(old.b_rad_s) - Vector3::from(new.b_rad_s));
        if old.p == new.p {
            return;
        }
        let change = new.p_matrix() - old.p_matrix();
        let of_axes = change.column_iter().map(|column| column.norm_squared() / 3.0);
        let change = of_axes.fold(0.0, |most, x| if x > most { x } else { most });
        let is_other = change > DOUBTED * DOUBTED * self.scale_sigma * self.scale_sigma;
        self.sigmas_stale = true;
        if !is_other {
            // Within what the gyro was thought to be: nothing is known anew.
            return;
        }
        self.bias_rad_s = Vector3::zeros();
        if self.heading_blocks > 1 {
            // the heading was carried by a gyro that is worse than was thought: it is taken from the next field
            self.errors.open(HEADING, PI * PI);
            self.heading_blocks = 1;
        }
        let between = |x: f32, least: f32, most: f32| {
            if x > most {
                most
            } else if x > least {
                x
            } else {
                least
            }
        };
        let mean_square = sigma.iter().take(9).fold(0.0, |sum, s| sum + s * s) / 9.0;
        self.scale_sigma = between(libm::sqrtf(mean_square), LEAST_SCALE, config.gyro_scale_sigma);
        for (k, sigma) in sigma.iter().skip(9).enumerate() {
            let sigma = between(*sigma, LEAST_BIAS_RAD_S, config.gyro_bias_sigma_rad_s);
            self.errors.open(BIAS + k, sigma * sigma);
        }
    }

    /// What is taken out of the field has changed: its reference is averaged anew.
    pub const fn field_changed(&mut self) {
        self.reference.relearn();
    }

    /// Whether the gyro's delay is known; else the attitude is uncertain by what the probe turns in half a sample period more or less,
    /// uniform.
    pub const fn gyro_delay_known(&mut self, known: bool) {
        self.gyro_timing_variance = if known { 0.0 } else { 1.0 / 12.0 };
    }

    /// The magnetometer's delay against the gyro has been taken out, within `sigma_s` seconds; `None`: it is no longer known.
    pub fn mag_delay_known(&mut self, sigma_s: Option<f32>) {
        let Some((config, _)) = self.settings() else { return };
        self.timing_variance_s2 = match sigma_s {
            Some(sigma_s) => sigma_s * sigma_s + LEAST_TIMING_S * LEAST_TIMING_S,
            None => config.mag_timing_sigma_s * config.mag_timing_sigma_s,
        };
    }
}
