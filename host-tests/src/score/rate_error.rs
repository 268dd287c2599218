//! Rate error against the true rate, which only a simulated trace knows.

use meerkat_mwd::compensation::GyroModel;
use nalgebra::{Matrix3, Vector3};

use super::{rates::Compensation, root_mean_square};

/// Systematic rate error of an estimated gyro model, rad/s: compensated minus true, root mean square over samples and axes, of a
/// gyro with the true model and no noise. `None` without a rate, or where the true P cannot be inverted.
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

/// Rate error with everything in it, rad/s: compensated minus true, root mean square over samples and axes. `None` of nothing.
#[must_use]
pub fn rate_error_rad_s(compensated_rad_s: &[[f64; 3]], true_rates_rad_s: &[[f64; 3]]) -> Option<f64> {
    let pairs = compensated_rad_s.iter().flatten().zip(true_rates_rad_s.iter().flatten());
    root_mean_square(pairs.map(|(compensated, truth)| compensated - truth))
}
