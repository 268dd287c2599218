//! Rate error against the true rate of a simulated trace.

use meerkat_mwd::compensation::GyroModel;
use nalgebra::{Matrix3, Vector3};

use super::{rates::Compensation, root_mean_square};

/// Systematic rate error of a gyro model, rad/s: compensated minus true rate, rms over samples and axes, for
/// a noiseless gyro with the true model. `None` without rates, or if the true P has no inverse.
#[must_use]
pub fn systematic_rate_error_rad_s(
    true_model: &GyroModel,
    estimate: &GyroModel,
    true_rates_rad_s: &[[f64; 3]],
) -> Option<f64> {
    let (truth, estimate) = (Compensation::new(true_model), Compensation::new(estimate));
    let inverse: Matrix3<f64> = truth.p.try_inverse()?;
    root_mean_square(true_rates_rad_s.iter().flat_map(|&rate| {
        let rate = Vector3::from(rate);
        let raw = inverse * rate + truth.b_rad_s;
        <[f64; 3]>::from(estimate.rate(&raw) - rate)
    }))
}

/// Whole rate error, rad/s: compensated minus true, rms over samples and axes. `None` without rates.
#[must_use]
pub fn rate_error_rad_s(compensated_rad_s: &[[f64; 3]], true_rates_rad_s: &[[f64; 3]]) -> Option<f64> {
    let pairs = compensated_rad_s.iter().flatten().zip(true_rates_rad_s.iter().flatten());
    root_mean_square(pairs.map(|(compensated, truth)| compensated - truth))
}
