//! Bayesian Cramer-Rao bound of the 12 parameters for one window of a simulated run (van Trees 1968, section
//! 2.4).
//!
//! Readings follow the simulator's model, linearised about the truth. It is then linear and Gaussian, and the
//! bound is the posterior covariance of a Kalman filter over the error state. The trajectory is a nuisance:
//! the rate is known only from the gyro and from standing still at rest. The attitude at the start is free.
//!
//! The prior is the library's, wider than the simulator's distribution. It makes no difference where a window
//! shows the parameters; elsewhere an estimate that stays at the prior's mean can err by less than the bound.
//!
//! Omissions make the bound lower, so that it remains a bound: shocks, the bit's chatter, full scales and
//! rounding are left out, and the earth's gravity and field are known exactly.

pub mod error_state;

use error_state::{C, ErrorState, VectorSensor, VectorSigmas};
use meerkat_mwd::{
    compensation::GyroModel,
    config::{IdentificationConfig, VectorErrors},
};
use nalgebra::{Matrix3, Quaternion, SMatrix, SVector, UnitQuaternion, Vector3};

use crate::{
    simulate::{Scenario, Truth, random::Random, sensors::SensorNoise, vibration::HighPassed},
    trace::Trace,
};

/// Knowledge of the vibration's spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vibration {
    /// Full knowledge: the simulator's high-pass in tool axes. Gravity is sharp then, because the vibration
    /// has no slow part in these axes; a real tool that stays in its hole has none in the earth's.
    Coloured,
    /// Knowledge of what remains in means over a fifth of a second, as if the vibration were white.
    White,
}

/// Knowledge that the bound assumes beside the gyro.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Known {
    /// Knowledge of the vibration.
    pub vibration: Vibration,
    /// True if accelerometer and magnetometer are known to be perfect, as the simulator's are; else their matrices,
    /// offsets and delays are as uncertain as the configuration says.
    pub vectors: bool,
}

impl From<Vibration> for Known {
    /// With perfect vector sensors.
    fn from(vibration: Vibration) -> Self {
        Self { vibration, vectors: true }
    }
}

/// Length of the mean that [`Vibration::White`] knows, seconds.
pub const MEAN_S: f64 = 0.2;

/// Least covariance of an unbiased estimate of theta = (P row-major, c = P b) at the end of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Covariance of P, dimensionless, and c, rad/s.
    pub covariance: SMatrix<f64, 12, 12>,
}

impl Bound {
    /// The bound from the samples up to and including `last`, from the first of the run on.
    #[must_use]
    pub fn of_window(
        scenario: &Scenario,
        trace: &Trace,
        truth: &Truth,
        last: usize,
        prior: &IdentificationConfig,
        known: Known,
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
        if !known.vectors {
            filter.doubt_vectors(&vector_sigmas(&prior.vector_errors, scenario.earth.magnetic_field_ut));
        }
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
                filter.turn(&rate, &raw, &Vector3::zeros(), period_s);
                filter.add_noise(0, &(p * p.transpose() * (noise.gyro_rad_s * period_s).powi(2)));
            }
            if still {
                filter.observe_rest(&inverse, &bias, &Vector3::zeros(), noise.gyro_rad_s);
            }
            let drilling = scenario.drilling_at(t_s).0;
            let (shaken, accel_m_s2) = match known.vibration {
                Vibration::Coloured => {
                    (vibration.scale_m_s2 * (drilling * (1.0 - vibration.smoothing)), Vector3::repeat(noise.accel_m_s2))
                }
                Vibration::White => {
                    (Vector3::zeros(), (white_m_s2 * drilling).map(|white| libm::hypot(white, noise.accel_m_s2)))
                }
            };
            let none = Vector3::zeros();
            let sensor = (VectorSensor::Accelerometer, &rate);
            filter.observe_vector(sensor, &(to_body * force_m_s2), &none, &shaken, &accel_m_s2);
            let sensor = (VectorSensor::Magnetometer, &rate);
            filter.observe_vector(sensor, &(to_body * field_ut), &none, &none, &Vector3::repeat(noise.mag_ut));
            if index < last {
                filter.add_noise(C, &(p * p.transpose() * noise.bias_step_rad_s.powi(2)));
                filter.next_vibration(vibration.smoothing);
            }
            still_before = still;
        }
        Self { covariance: filter.theta() }
    }

    /// The bound some time later without further readings: the bias has walked on.
    #[must_use]
    pub fn later(mut self, scenario: &Scenario, truth: &GyroModel, samples: usize) -> Self {
        let p = truth.p_matrix().map(f64::from);
        let walked = SensorNoise::of(scenario).bias_step_rad_s.powi(2) * samples as f64;
        let mut block = self.covariance.fixed_view_mut::<3, 3>(9, 9);
        block += p * p.transpose() * walked;
        self
    }

    /// Rms of the systematic rate error over rates, axes and the posterior, rad/s: the root of the mean of
    /// tr(W C W^T) / 3 with W = [raw (x) I, -I] of each sample. It bounds
    /// [`crate::score::systematic_rate_error_rad_s`].
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
    /// An estimate as good as the bound allows: the truth plus an error drawn from the covariance.
    #[must_use]
    pub fn draw(&self, truth: &GyroModel, seed: u64) -> GyroModel {
        let mut random = Random::new(seed);
        let unit = SVector::<f64, 12>::from_fn(|_, _| random.normal());
        // A filter's covariance is positive definite, apart from rounding.
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

/// The library's prior deviations of theta.
#[must_use]
pub fn prior_sigmas(prior: &IdentificationConfig) -> [f64; 12] {
    std::array::from_fn(|i| {
        f64::from(match i {
            0 | 4 | 8 => prior.prior_sigma_diagonal,
            0..9 => prior.prior_sigma_off_diagonal,
            _ => prior.prior_sigma_bias_rad_s,
        })
    })
}

/// Deviations of the errors of accelerometer and magnetometer, as the configuration states them.
fn vector_sigmas(errors: &VectorErrors, field_ut: f64) -> [VectorSigmas; 2] {
    let of = |matrix: f32, offset: f64, delay_s: f32| {
        std::array::from_fn(|k| match k {
            0..9 => f64::from(matrix),
            9..12 => offset,
            _ => f64::from(delay_s),
        })
    };
    [
        of(errors.accel_matrix, f64::from(errors.accel_bias_m_s2), errors.accel_lag_s),
        of(errors.mag_matrix, f64::from(errors.hard_iron) * field_ut, errors.mag_lag_s),
    ]
}
