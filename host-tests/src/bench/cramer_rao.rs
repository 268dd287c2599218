//! The Bayesian Cramer-Rao bound of the 12 parameters for one window of a simulated run (van Trees 1968, section 2.4).
//!
//! The model of the readings is the simulator's, linearised about the truth; it is then linear and Gaussian, and the bound is the
//! posterior covariance of a Kalman filter over the error state. The trajectory is a nuisance: nothing is known of the rate except
//! what the gyro reads, and that the tool stands still while it rests. The attitude at the start is free.
//!
//! The prior is the library's, wider than what the simulator draws from. Where a window shows the parameters that makes no
//! difference; where it does not, an estimate that stays at the prior's mean can err by less than the bound.
//!
//! Whatever is left out makes the bound lower, so that it stays one: shocks, the bit's chatter, full scales and rounding are left
//! out, and gravity and field of the earth are known exactly.

use meerkat_mwd::{compensation::GyroModel, config::IdentificationConfig};
use nalgebra::{Matrix3, Matrix3x6, Quaternion, Rotation3, SMatrix, SVector, UnitQuaternion, Vector3};

use crate::{
    simulate::{Scenario, Truth, random::Random, sensors::SensorNoise, vibration::HighPassed},
    trace::Trace,
};

/// Attitude error 3, P 9 (row-major), c = P b 3, low-pass of the vibration 3, its white noise in this sample 3.
const STATES: usize = 21;
const THETA: usize = 3;
const C: usize = 12;
const LOW: usize = 15;
const WHITE: usize = 18;

/// Of the attitude at the start, rad: nothing is known of it.
const FREE_RAD: f64 = 10.0;

/// What is known of the vibration's spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vibration {
    /// All: the simulator's high-pass in tool axes. Then gravity is sharp, for the vibration has no slow part in these axes; a tool's has none in
    /// the earth's, if it stays in its hole.
    Coloured,
    /// How much is left of it in means over a fifth of a second, as if it were white.
    White,
}

/// A mean over this long is what [`Vibration::White`] knows, seconds.
const MEAN_S: f64 = 0.2;

/// The least covariance that an unbiased estimate of theta = (P row-major, c = P b) can have, at the end of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Of P, dimensionless, and c, rad/s.
    pub covariance: SMatrix<f64, 12, 12>,
}

impl Bound {
    /// The bound of the samples up to and including `last`, from the first one of the run on.
    #[must_use]
    pub fn of_window(
        scenario: &Scenario,
        trace: &Trace,
        truth: &Truth,
        last: usize,
        prior: &IdentificationConfig,
        known: Vibration,
    ) -> Self {
        let noise = SensorNoise::of(scenario);
        let vibration = HighPassed::of(scenario);
        let white_m_s2 = vibration.white_m_s2((1e6 * MEAN_S) as u32 / scenario.sample_period_us);
        let p = truth.gyro.p_matrix().map(f64::from);
        let inverse = p.try_inverse().unwrap_or_else(Matrix3::identity);
        let period_s = f64::from(scenario.sample_period_us) * 1e-6;
        let (sine, cosine) = scenario.earth.dip_deg.to_radians().sin_cos();
        let field_ut = Vector3::new(cosine, 0.0, sine) * scenario.earth.magnetic_field_ut;
        let force_m_s2 = Vector3::new(0.0, 0.0, -scenario.earth.gravity_m_s2);

        let mut filter = ErrorState::new(&prior_sigmas(prior));
        let rates = trace.true_rate.as_deref().unwrap_or_default();
        let mut still_before = false;
        for (index, (rate, q)) in rates.iter().zip(&trace.reference).enumerate().take(last + 1) {
            let Some([w, x, y, z]) = *q else { continue };
            let to_body = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).inverse();
            let t_s = index as f64 * period_s;
            let still = t_s + 0.5 * period_s <= scenario.rest_s;
            let bias = Vector3::from(truth.gyro_at(index).b_rad_s.map(f64::from));
            let rate = Vector3::from(*rate);
            let raw = inverse * rate + bias;
            if index > 0 && !(still && still_before) {
                filter.turn(&rate, &raw, period_s);
                filter.add_noise(0, &(p * p.transpose() * (noise.gyro_rad_s * period_s).powi(2)));
            }
            if still {
                filter.observe_rest(&inverse, &bias, noise.gyro_rad_s);
            }
            let drilling = scenario.drilling_at(t_s).0;
            let (shaken, accel_m_s2) = match known {
                Vibration::Coloured => {
                    (vibration.scale_m_s2 * (drilling * (1.0 - vibration.smoothing)), Vector3::repeat(noise.accel_m_s2))
                }
                Vibration::White => {
                    (Vector3::zeros(), (white_m_s2 * drilling).map(|white| libm::hypot(white, noise.accel_m_s2)))
                }
            };
            filter.observe_vector(&(to_body * force_m_s2), &shaken, &accel_m_s2);
            filter.observe_vector(&(to_body * field_ut), &Vector3::zeros(), &Vector3::repeat(noise.mag_ut));
            if index < last {
                filter.add_noise(C, &(p * p.transpose() * noise.bias_step_rad_s.powi(2)));
                filter.next_vibration(vibration.smoothing);
            }
            still_before = still;
        }
        Self { covariance: filter.covariance.fixed_view::<12, 12>(THETA, THETA).into_owned() }
    }

    /// The same so much later, nothing more having been read: the bias has walked on.
    #[must_use]
    pub fn later(mut self, scenario: &Scenario, truth: &GyroModel, samples: usize) -> Self {
        let p = truth.p_matrix().map(f64::from);
        let walked = SensorNoise::of(scenario).bias_step_rad_s.powi(2) * samples as f64;
        let mut block = self.covariance.fixed_view_mut::<3, 3>(9, 9);
        block += p * p.transpose() * walked;
        self
    }

    /// Root mean square over the rates, their axes and the posterior of the systematic rate error, rad/s: with
    /// W = [raw (x) I, -I] of each sample the root of the mean of tr(W C W^T) / 3. What
    /// [`crate::score::systematic_rate_error_rad_s`] measures of an estimate.
    #[must_use]
    pub fn rate_error_rad_s(&self, truth: &GyroModel, true_rates_rad_s: &[[f64; 3]]) -> f64 {
        let inverse = truth.p_matrix().map(f64::from).try_inverse().unwrap_or_else(Matrix3::identity);
        let bias = Vector3::from(truth.b_rad_s.map(f64::from));
        let mut moments = SMatrix::<f64, 4, 4>::zeros();
        for &rate in true_rates_rad_s {
            let raw = (inverse * Vector3::from(rate) + bias).push(-1.0);
            moments += raw * raw.transpose();
        }
        // Row i of the error is (raw, -1) . (P_i0, P_i1, P_i2, c_i).
        let element = |row: usize, k: usize| if k < 3 { 3 * row + k } else { 9 + row };
        let mut sum = 0.0;
        for row in 0..3 {
            for (k, l) in (0..16).map(|kl| (kl / 4, kl % 4)) {
                sum += moments[(k, l)] * self.covariance[(element(row, k), element(row, l))];
            }
        }
        (sum / (3.0 * true_rates_rad_s.len() as f64)).sqrt()
    }
}

impl Bound {
    /// An estimate as good as the bound allows: the truth with an error drawn from the covariance.
    #[must_use]
    pub fn draw(&self, truth: &GyroModel, seed: u64) -> GyroModel {
        let mut random = Random::new(seed);
        let unit = SVector::<f64, 12>::from_fn(|_, _| random.normal());
        // A covariance of a filter is positive definite but for rounding.
        let error = self.covariance.cholesky().map_or_else(SVector::zeros, |factor| factor.l() * unit);
        let true_p = truth.p_matrix().map(f64::from);
        let p = true_p + Matrix3::from_fn(|i, j| error[3 * i + j]);
        let c = true_p * Vector3::from(truth.b_rad_s.map(f64::from)) + error.fixed_rows::<3>(9);
        let b = p.try_inverse().map_or(c, |inverse| inverse * c);
        GyroModel {
            p: std::array::from_fn(|i| std::array::from_fn(|j| p[(i, j)] as f32)),
            b_rad_s: b.map(|x| x as f32).into(),
        }
    }
}

/// What the library is told of theta before a window.
fn prior_sigmas(prior: &IdentificationConfig) -> [f64; 12] {
    std::array::from_fn(|i| {
        f64::from(match i {
            0 | 4 | 8 => prior.prior_sigma_diagonal,
            0..9 => prior.prior_sigma_off_diagonal,
            _ => prior.prior_sigma_bias_rad_s,
        })
    })
}

/// Covariance of the error state. Attitude: true tool-to-earth rotation = estimated one times exp(error), tool axes.
struct ErrorState {
    covariance: SMatrix<f64, STATES, STATES>,
}

impl ErrorState {
    fn new(theta_sigmas: &[f64; 12]) -> Self {
        let mut sigmas = SVector::<f64, STATES>::zeros();
        sigmas.fixed_rows_mut::<3>(0).fill(FREE_RAD);
        sigmas.fixed_rows_mut::<12>(THETA).copy_from_slice(theta_sigmas);
        sigmas.fixed_rows_mut::<3>(WHITE).fill(1.0);
        Self { covariance: SMatrix::from_diagonal(&sigmas.map(|s| s * s)) }
    }

    /// Turns with `rate` over `step_s`: the attitude error turns the other way and takes in the rate's, dP raw - dc.
    fn turn(&mut self, rate_rad_s: &Vector3<f64>, raw_rad_s: &Vector3<f64>, step_s: f64) {
        let whole = Rotation3::new(-rate_rad_s * step_s).into_inner();
        // The mean over the step of the rotations that are left to its end.
        let mean = Rotation3::new(-rate_rad_s * (0.5 * step_s)).into_inner() * step_s;
        let mut input = SMatrix::<f64, 3, 12>::zeros();
        for row in 0..3 {
            for column in 0..3 {
                input.set_column(3 * row + column, &(mean.column(row) * raw_rad_s[column]));
            }
            input.set_column(9 + row, &-mean.column(row));
        }
        let rows: SMatrix<f64, 3, STATES> =
            whole * self.covariance.fixed_rows::<3>(0) + input * self.covariance.fixed_rows::<12>(THETA);
        let attitude =
            rows.fixed_columns::<3>(0) * whole.transpose() + rows.fixed_columns::<12>(THETA) * input.transpose();
        self.covariance.fixed_rows_mut::<3>(0).copy_from(&rows);
        self.covariance.fixed_columns_mut::<3>(0).copy_from(&rows.transpose());
        self.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&(0.5 * (attitude + attitude.transpose())));
    }

    /// Adds noise to the three states from `first` on.
    fn add_noise(&mut self, first: usize, covariance: &Matrix3<f64>) {
        let mut block = self.covariance.fixed_view_mut::<3, 3>(first, first);
        block += covariance;
    }

    /// The tool stands still: the reading is the bias, P^-1 (P raw - c) = noise.
    fn observe_rest(&mut self, inverse: &Matrix3<f64>, bias_rad_s: &Vector3<f64>, sigma_rad_s: f64) {
        for axis in 0..3 {
            let mut row = SVector::<f64, STATES>::zeros();
            for i in 0..3 {
                for j in 0..3 {
                    row[THETA + 3 * i + j] = inverse[(axis, i)] * bias_rad_s[j];
                }
                row[C + i] = -inverse[(axis, i)];
            }
            self.observe(&row, sigma_rad_s);
        }
    }

    /// A reading of an earth-fixed vector whose true value in tool axes is `vector`, with vibration `shaken` (white - low) in it.
    fn observe_vector(&mut self, vector: &Vector3<f64>, shaken: &Vector3<f64>, sigmas: &Vector3<f64>) {
        // exp(-error) v = v + v x error.
        let cross = vector.cross_matrix();
        let both = Matrix3x6::from_fn(|i, j| match j {
            _ if i != j % 3 => 0.0,
            0..3 => -shaken[i],
            _ => shaken[i],
        });
        for axis in 0..3 {
            let mut row = SVector::<f64, STATES>::zeros();
            row.fixed_rows_mut::<3>(0).copy_from(&cross.row(axis).transpose());
            row.fixed_rows_mut::<6>(LOW).copy_from(&both.row(axis).transpose());
            self.observe(&row, sigmas[axis]);
        }
    }

    fn observe(&mut self, row: &SVector<f64, STATES>, sigma: f64) {
        let cross = self.covariance * row;
        let variance = cross.dot(row) + sigma * sigma;
        self.covariance.ger(-1.0 / variance, &cross, &cross, 1.0);
    }

    /// The low-pass takes in this sample's white noise, and the next one is drawn.
    fn next_vibration(&mut self, smoothing: f64) {
        for axis in 0..3 {
            let (low, white) = (LOW + axis, WHITE + axis);
            let row = self.covariance.row(low) * (1.0 - smoothing) + self.covariance.row(white) * smoothing;
            self.covariance.set_row(low, &row);
            let column = self.covariance.column(low) * (1.0 - smoothing) + self.covariance.column(white) * smoothing;
            self.covariance.set_column(low, &column);
            self.covariance.row_mut(white).fill(0.0);
            self.covariance.column_mut(white).fill(0.0);
            self.covariance[(white, white)] = 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known but for the scale factor about z: the angle between two readings of a field across the axis, over the angle turned.
    #[test]
    fn the_scale_of_one_axis_is_that_of_two_angles_and_the_gyros_noise_between() {
        let (rate, step_s, steps) = (Vector3::new(0.0, 0.0, 1.5), 0.01, 2_000);
        let (field, sigma_ut, noise) = (50.0, 0.2, 2e-4);
        let mut sigmas = [1e-9; 12];
        sigmas[8] = 1.0;
        let mut filter = ErrorState::new(&sigmas);
        let mut angle = 0.0_f64;
        let look = |filter: &mut ErrorState, angle: f64| {
            let body = Vector3::new(field * angle.cos(), -field * angle.sin(), 0.0);
            filter.observe_vector(&body, &Vector3::zeros(), &Vector3::repeat(sigma_ut));
        };
        look(&mut filter, angle);
        for _ in 0..steps {
            filter.turn(&rate, &rate, step_s);
            filter.add_noise(0, &Matrix3::from_diagonal_element((noise * step_s).powi(2)));
            angle += rate.z * step_s;
        }
        look(&mut filter, angle);
        let walked = noise * step_s * f64::from(steps).sqrt();
        let expected = (2.0 * (sigma_ut / field).powi(2) + walked * walked).sqrt() / angle;
        let found = filter.covariance[(THETA + 8, THETA + 8)].sqrt();
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }

    /// With nothing but rest, c has the variance of a mean; with a walk it has the filter's known stationary value.
    #[test]
    fn a_rest_gives_the_bias_as_a_mean_does() {
        let mut filter = ErrorState::new(&[1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1.0, 1.0, 1.0]);
        for _ in 0..1_000 {
            filter.observe_rest(&Matrix3::identity(), &Vector3::new(0.02, -0.01, 0.03), 2e-3);
        }
        let found = filter.covariance[(C, C)].sqrt();
        assert!((found / (2e-3 / 1_000_f64.sqrt()) - 1.0).abs() < 1e-3, "{found}");
        // Walk q a step, reading r: before each reading the variance is (q^2 + sqrt(q^4 + 4 q^2 r^2)) / 2.
        let (q, r) = (1e-4_f64, 2e-3_f64);
        for _ in 0..10_000 {
            filter.observe_rest(&Matrix3::identity(), &Vector3::zeros(), r);
            filter.add_noise(C, &Matrix3::from_diagonal_element(q * q));
        }
        let expected = 0.5 * (q * q + (q.powi(4) + 4.0 * q * q * r * r).sqrt());
        assert!((filter.covariance[(C, C)] / expected - 1.0).abs() < 1e-6);
    }

    /// The mean of high-passed noise averages out faster than white noise: its sum is the low-pass's lag, which is bounded.
    #[test]
    fn vibration_without_a_slow_part_leaves_a_mean_that_falls_with_the_time() {
        let sigma = |samples: usize| {
            let mut filter = ErrorState::new(&[1e-9; 12]);
            for _ in 0..samples {
                filter.observe_vector(&Vector3::new(0.0, 0.0, 9.8), &Vector3::repeat(3.0), &Vector3::repeat(1e-3));
                filter.next_vibration(0.12);
            }
            filter.covariance[(0, 0)].sqrt()
        };
        let ratio = sigma(200) / sigma(1_600);
        assert!(ratio > 7.0, "white noise would give the square root of 8: {ratio}");
    }
}
