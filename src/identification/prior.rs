#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::Carried;
use crate::{
    algebra::{Packed, dot},
    compensation::GyroModel,
    config::IdentificationConfig,
    window::RestBias,
};
use nalgebra::{Matrix3, Vector3};

/// What is known of theta = (P row-major, c = P b) before a window: the factory's values with the data sheet's deviations, and
/// the bias where the tool has been at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prior {
    /// Information (inverse covariance).
    pub information: Packed<12, 78>,
    mean: [f32; 12],
}

impl Prior {
    pub const fn zero() -> Self {
        Self { information: Packed::zero(), mean: [0.0; 12] }
    }

    /// A rest says c - P b_rest = 0 within its sigma; without one c has the data sheet's deviation about the factory's.
    pub fn new(config: &IdentificationConfig, factory: &GyroModel, rest: Option<&RestBias>) -> Self {
        let inverse_square = |sigma: f32| 1.0 / (sigma * sigma);
        let mut information = Packed::zero();
        let sigma = prior_sigma(config);
        for i in 0..9 {
            information.add(i, i, inverse_square(sigma[i]));
        }
        let bias = rest.map_or(factory.b_rad_s, |rest| rest.rate.into());
        match rest {
            None => {
                for i in 9..12 {
                    information.add(i, i, inverse_square(sigma[i]));
                }
            }
            Some(rest) => {
                for i in 0..3 {
                    let mut row = [0.0; 12];
                    row[9 + i] = 1.0;
                    for j in 0..3 {
                        row[3 * i + j] = -bias[j];
                    }
                    information.add_outer(&row, inverse_square(rest.sigma_rad_s()));
                }
            }
        }
        Self { information, mean: theta_of(&GyroModel { p: factory.p, b_rad_s: bias }) }
    }

    /// With what earlier windows have taught beside it; as it is where the two cannot be put together.
    pub fn with(&self, carried: &Carried) -> Self {
        let mut both = *self;
        both.information.add_scaled(&carried.information, 1.0);
        let offset = core::array::from_fn(|i| carried.mean[i] - self.mean[i]);
        let Some(factor) = both.information.cholesky() else { return *self };
        let shift = factor.solve(&carried.information.times(&offset));
        if !shift.iter().all(|x| x.is_finite()) {
            return *self;
        }
        for (mean, x) in both.mean.iter_mut().zip(&shift) {
            *mean += x;
        }
        both
    }

    /// Adds equations with this normal matrix; their most probable theta, beside what was known before, is the mean.
    pub fn learn(&mut self, normal: &Packed<12, 78>, weight: f32, mean: [f32; 12]) {
        self.information.add_scaled(normal, weight);
        self.mean = mean;
    }

    /// Half the squared distance of theta0 + delta from the mean, in the prior's metric.
    pub fn cost(&self, theta0: &[f32; 12], delta: &[f32; 12]) -> f32 {
        0.5 * self.information.quadratic(&self.offset(theta0, delta))
    }

    /// The direction of descent of that: information times (mean - theta).
    pub fn descent(&self, theta0: &[f32; 12], delta: &[f32; 12]) -> [f32; 12] {
        self.information.times(&self.offset(theta0, delta)).map(|x| -x)
    }

    fn offset(&self, theta0: &[f32; 12], delta: &[f32; 12]) -> [f32; 12] {
        let mut offset = *theta0;
        for ((x, d), m) in offset.iter_mut().zip(delta).zip(&self.mean) {
            *x += d - m;
        }
        offset
    }
}

/// theta = (P row-major, c = P b): w = P w_raw - c is linear in it.
pub(crate) fn theta_of(model: &GyroModel) -> [f32; 12] {
    let mut theta = [0.0; 12];
    for i in 0..3 {
        theta[3 * i..3 * i + 3].copy_from_slice(&model.p[i]);
        theta[9 + i] = dot(&model.p[i], &model.b_rad_s);
    }
    theta
}

/// The model of a theta; `None` when P cannot be inverted or something is not finite.
pub(crate) fn model_of(theta: &[f32; 12]) -> Option<GyroModel> {
    let row = |i: usize| [theta[3 * i], theta[3 * i + 1], theta[3 * i + 2]];
    let p_only = GyroModel { p: [row(0), row(1), row(2)], b_rad_s: [0.0; 3] };
    if !p_only.is_valid() {
        return None;
    }
    let inverse = p_only.p_matrix().try_inverse()?;
    let b = inverse * Vector3::new(theta[9], theta[10], theta[11]);
    let model = GyroModel { b_rad_s: b.into(), ..p_only };
    model.is_valid().then_some(model)
}

/// theta as the matrix P and the vector c.
pub(crate) fn linear(theta: &[f32; 12]) -> (Matrix3<f32>, Vector3<f32>) {
    (Matrix3::from_fn(|i, j| theta[3 * i + j]), Vector3::new(theta[9], theta[10], theta[11]))
}

/// Prior standard deviations of P (row-major) and c or b.
pub(crate) fn prior_sigma(config: &IdentificationConfig) -> [f32; 12] {
    core::array::from_fn(|i| match i {
        0 | 4 | 8 => config.prior_sigma_diagonal,
        0..9 => config.prior_sigma_off_diagonal,
        _ => config.prior_sigma_bias_rad_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn theta_and_model_are_the_same_thing() {
        let model =
            GyroModel { p: [[1.05, 0.02, -0.01], [0.03, 0.97, 0.0], [-0.02, 0.01, 1.1]], b_rad_s: [0.03, -0.01, 0.02] };
        let back = model_of(&theta_of(&model)).unwrap();
        for i in 0..3 {
            assert_eq!(back.p[i], model.p[i]);
            assert!((back.b_rad_s[i] - model.b_rad_s[i]).abs() < 1e-8);
        }
        assert!(model_of(&[0.0; 12]).is_none());
    }

    #[test]
    fn with_a_rest_the_prior_costs_nothing_on_every_p_whose_c_is_p_times_the_bias() {
        let rest = RestBias {
            rate: Vector3::new(0.03, -0.02, 0.01),
            variance: 1e-8,
            force_m_s2: Vector3::zeros(),
            warming_k: 0.0,
        };
        let config = IdentificationConfig::default();
        let prior = Prior::new(&config, &GyroModel::IDENTITY, Some(&rest));
        let mut model = GyroModel { b_rad_s: rest.rate.into(), ..GyroModel::IDENTITY };
        assert!(prior.cost(&theta_of(&model), &[0.0; 12]) < 1e-6);
        model.p[0][1] = 2.0 * config.prior_sigma_off_diagonal;
        assert!((prior.cost(&theta_of(&model), &[0.0; 12]) - 2.0).abs() < 1e-2, "two sigmas cost two");
        model.b_rad_s[0] += 2.0 * rest.sigma_rad_s();
        assert!((prior.cost(&theta_of(&model), &[0.0; 12]) - 4.0).abs() < 0.1, "and two more of the bias two more");
    }
}
