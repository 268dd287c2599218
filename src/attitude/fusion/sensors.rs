//! News of the sensors while the filter runs: another gyro model, other effects, a delay.

use super::{AttitudeFilter, BIAS, HEADING, PI};
use crate::compensation::GyroModel;
use nalgebra::Vector3;

/// Least scale error after compensation: the gyro's nonlinearity, 0.1 % (MPU-9250 PS section 3.1).
const LEAST_SCALE: f32 = 1e-3;
/// Least bias error after compensation, rad/s: the gyro's sensitivity to 1 g, 0.1 deg/s (MPU-6000 PS section
/// 6.1).
const LEAST_BIAS_RAD_S: f32 = 1.75e-3;
/// Least uncertainty of a known delay, seconds (the default of `SurveyErrors::mag_timing_s`).
const LEAST_TIMING_S: f32 = 1e-3;
/// Change of P, in sigmas, beyond which the former P was wrong: 95 %.
const DOUBTED: f32 = 2.0;

impl AttitudeFilter {
    /// Swaps the gyro model. The attitude stays. While P stays, so does the total bias: the residual one
    /// takes the difference and keeps its deviation, so that the filter alone owns the bias. With another P
    /// the residual bias is dropped, because it was partly P's error, and the new model's deviations (P
    /// row-major, then b, rad/s) replace the configured ones where they are smaller.
    pub fn model_changed(&mut self, old: &GyroModel, new: &GyroModel, sigma: &[f32; 12]) {
        let Some((config, _)) = self.settings() else { return };
        // The learnt total bias stays valid under the new model.
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
            // The change is within what the gyro was thought to be: nothing new is known.
            return;
        }
        self.bias_rad_s = Vector3::zeros();
        if self.heading_blocks > 1 {
            // The heading was carried by a gyro worse than assumed; the next field gives it again.
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

    /// Restarts the average of the field's reference, after a change in what is taken out of the field.
    pub const fn field_changed(&mut self) {
        self.reference.relearn();
    }

    /// Sets whether the gyro's delay is known. If not, the attitude is uncertain by the turn of half a sample
    /// period either way, uniform.
    pub const fn gyro_delay_known(&mut self, known: bool) {
        self.gyro_timing_variance = if known { 0.0 } else { 1.0 / 12.0 };
    }

    /// Sets the magnetometer's delay against the gyro as taken out within `sigma_s` seconds; `None`: not
    /// known.
    pub fn mag_delay_known(&mut self, sigma_s: Option<f32>) {
        let Some((config, _)) = self.settings() else { return };
        self.timing_variance_s2 = match sigma_s {
            Some(sigma_s) => sigma_s * sigma_s + LEAST_TIMING_S * LEAST_TIMING_S,
            None => config.mag_timing_sigma_s * config.mag_timing_sigma_s,
        };
    }
}
