//! The weak form of the vectors' kinematics, implemented a second time: u' = R0 [v]x dw, multiplied by sin^2
//! and integrated by parts.

use std::f64::consts::PI;

use nalgebra::{SMatrix, Vector3};

use super::{
    effort::Spent,
    loss::Loss,
    prior::Prior,
    readings::{Matrix12, Readings, Theta, add_gyro_rows},
};

/// Three equations `rows` theta = `right` of one sensor over one test window.
#[derive(Clone, Debug)]
pub(super) struct Equation {
    pub rows: SMatrix<f64, 3, 12>,
    pub right: Vector3<f64>,
    /// 0 gravity, 1 field.
    pub sensor: usize,
    /// True if a sample in it was hit; only the oracle may look.
    pub hit: bool,
}

/// The equations of a window with what is needed to solve them.
#[derive(Clone, Debug)]
pub(super) struct WeakForm<'a> {
    pub equations: Vec<Equation>,
    /// Standard deviation of one component of the equations of gravity (m/s^2) and field (microtesla).
    pub sigma: [f64; 2],
    pub prior: &'a Prior,
    /// True if an equation of gravity counts no more than that of the field over the same test window: a
    /// fault of the gyro spoils both, and only the field is sharp enough to show it.
    pub coupled: bool,
}

/// Length of a test window and step to the next, seconds. A sin^2 needs steps of a quarter of its length.
pub(super) const TEST_WINDOW_S: [f64; 2] = [1.0, 0.25];

/// White noise of the simulated magnetometer, microtesla.
const FIELD_NOISE_UT: f64 = 0.2;

/// Standard deviation of gravity's equations over a test window of 1 s under the simulated vibration, m/s^2,
/// measured.
const GRAVITY_SIGMA: f64 = 0.28;

/// Deviation of one component of clean equations. The field's is the sensor's white noise through phi': the
/// root of the sum of (phi' dt)^2 is pi sqrt(dt / 2 T). Vibration above 2 Hz leaves gravity an error that
/// goes as about 1 / T.
pub(super) fn nominal_sigma(period_s: f64, length_s: f64) -> [f64; 2] {
    [GRAVITY_SIGMA / length_s, FIELD_NOISE_UT * PI * libm::sqrt(0.5 * period_s / length_s)]
}

/// The equations of a window about the nominal rates of `nominal`, gravity's and the field's of each test
/// window in turn.
pub(super) fn equations(readings: &Readings, nominal: &Theta, [length_s, hop_s]: [f64; 2]) -> Vec<Equation> {
    let dt = readings.period_s;
    let (length, hop) = ((length_s / dt).round() as usize, (hop_s / dt).round() as usize);
    let attitudes = readings.attitudes(nominal);
    let mut all = Vec::new();
    let windows = readings.samples.windows(length).zip(attitudes.windows(length)).step_by(hop);
    for (samples, attitudes) in windows {
        for sensor in 0..2 {
            let mut equation = Equation { rows: SMatrix::zeros(), right: Vector3::zeros(), sensor, hit: false };
            for (k, (sample, rotation)) in samples.iter().zip(attitudes).enumerate() {
                let angle = PI * (k as f64 + 0.5) / length as f64;
                let (sine, cosine) = libm::sincos(angle);
                let v = sample.vectors[sensor];
                let gain = rotation * v.cross_matrix() * (sine * sine * dt);
                equation.right -= rotation * v * (2.0 * sine * cosine * PI / length as f64);
                add_gyro_rows(&mut equation.rows, &gain, &sample.raw);
                equation.hit |= sample.hit[0] || sample.hit[1 + sensor];
            }
            // The unknown is theta, not its change from the nominal.
            equation.right += equation.rows * nominal;
            all.push(equation);
        }
    }
    all
}

impl WeakForm<'_> {
    /// Squared norm of an equation's residual in standard deviations of one component.
    pub fn square(&self, equation: &Equation, theta: &Theta) -> f64 {
        let sigma = self.sigma[equation.sensor];
        (equation.rows * theta - equation.right).norm_squared() / (sigma * sigma)
    }

    pub fn squares(&self, theta: &Theta) -> Vec<f64> {
        self.equations.iter().map(|e| self.square(e, theta)).collect()
    }

    /// Normal matrix and right-hand side with these weights, prior included.
    pub fn normal(&self, weights: &[f64]) -> (Matrix12, Theta) {
        let mut normal = self.prior.information();
        let mut right = normal * self.prior.mean;
        for (equation, &weight) in self.equations.iter().zip(weights) {
            if weight > 0.0 {
                let sigma = self.sigma[equation.sensor];
                let transposed = equation.rows.transpose() * (weight / (sigma * sigma));
                normal.gemm(1.0, &transposed, &equation.rows, 1.0);
                right.gemv(1.0, &transposed, &equation.right, 1.0);
            }
        }
        (normal, right)
    }

    /// The weighted solution; the prior's mean if there is none.
    pub fn solve(&self, weights: &[f64]) -> Theta {
        let (normal, right) = self.normal(weights);
        normal.cholesky().map_or(self.prior.mean, |factor| factor.solve(&right))
    }

    pub fn weights(&self, loss: Loss, theta: &Theta) -> Vec<f64> {
        let mut weights: Vec<f64> = self.squares(theta).into_iter().map(|square| loss.weight(square)).collect();
        if self.coupled {
            for pair in weights.chunks_exact_mut(2) {
                pair[0] = pair[0].min(pair[1]);
            }
        }
        weights
    }

    /// The solution with every weight 1.
    pub fn unweighted(&self, spent: &mut Spent) -> Theta {
        spent.solve();
        self.solve(&vec![1.0; self.equations.len()])
    }

    /// Robust cost, prior included.
    pub fn cost(&self, loss: Loss, theta: &Theta) -> f64 {
        self.prior.cost(theta) + self.squares(theta).into_iter().map(|square| loss.value(square)).sum::<f64>()
    }
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::contaminated::{drilled::WINDOW, prior::Prior, readings::identity, window::Window};
    use testbed::simulate::{Scenario, simulate};

    /// Drilling without noise and vibration, and the gyro's true theta.
    pub(in crate::contaminated) fn noiseless() -> (Readings, Theta) {
        let mut scenario = Scenario { duration_s: 60.0, rest_s: 0.0, ..Scenario::default() };
        scenario.vibration.lateral_m_s2 = 0.0;
        scenario.vibration.axial_m_s2 = 0.0;
        scenario.vibration.chatter_m_s2 = 0.0;
        scenario.shocks.per_minute = 0.0;
        scenario.gyro.noise_deg_s_rthz = 0.0;
        scenario.gyro.bias_walk_deg_s_rts = 0.0;
        scenario.accel.noise_ug_rthz = 0.0;
        scenario.mag.noise_ut = 0.0;
        let (trace, truth) = simulate(&scenario, 3);
        let (p, b) = (truth.gyro.p.map(|row| row.map(f64::from)), truth.gyro.b_rad_s.map(f64::from));
        let theta = Theta::from_fn(|i, _| match i {
            0..9 => p[i / 3][i % 3],
            _ => (0..3).map(|j| p[i - 9][j] * b[j]).sum(),
        });
        (Readings::new(&trace, &WINDOW, None), theta)
    }

    #[test]
    fn a_gyro_error_of_any_size_is_found_without_noise() {
        let (readings, truth) = noiseless();
        let prior = Prior { sigma: Prior::data_sheet().sigma * 100.0, mean: identity() };
        let window = Window::new(readings, &prior, 1);
        let problem = window.weak_form(false);
        let theta = problem.solve(&vec![1.0; problem.equations.len()]);
        assert!((theta - truth).amax() < 2e-3, "{}", theta - truth);
    }
}
