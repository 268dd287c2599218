//! Kalman filter linearised about the truth: its covariance, and its estimate of the error.

use nalgebra::{Matrix3, Matrix3x6, Rotation3, SMatrix, SVector, Vector3};

/// States: attitude error 3, P 9 (row-major), c = P b 3, low-pass of the vibration 3, its white noise in this
/// sample 3, errors of accelerometer and magnetometer 13 each.
const STATES: usize = VECTORS + 2 * OF_A_VECTOR;
const THETA: usize = 3;
/// Index of c among the states.
pub const C: usize = 12;
const LOW: usize = 15;
const WHITE: usize = 18;
const VECTORS: usize = 21;
/// Errors of a vector sensor: its matrix 9 (row-major), offset 3, delay 1.
const OF_A_VECTOR: usize = 13;

/// Deviations of a vector sensor's constant errors, in the order of its states: dimensionless, the reading's unit,
/// seconds.
pub type VectorSigmas = [f64; OF_A_VECTOR];

/// A vector sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VectorSensor {
    /// Measures the specific force.
    Accelerometer = 0,
    /// Measures the field.
    Magnetometer = 1,
}

/// Deviation of the attitude at the start, rad: it is unknown.
const FREE_RAD: f64 = 10.0;

/// Covariance of the error state. Attitude: true tool-to-earth rotation = estimated one times exp(error),
/// tool axes.
pub struct ErrorState<const N: usize = 1> {
    /// Estimated error for each of N sets of readings; zero while every innovation is.
    estimate: SMatrix<f64, STATES, N>,
    /// Sums of products of whitened innovations, by pairs of sets.
    innovations: SMatrix<f64, N, N>,
    covariance: SMatrix<f64, STATES, STATES>,
}

impl<const N: usize> ErrorState<N> {
    /// Nothing is known but the deviations of P and b.
    #[must_use]
    pub fn new(theta_sigmas: &[f64; 12]) -> Self {
        let mut sigmas = SVector::<f64, STATES>::zeros();
        sigmas.fixed_rows_mut::<3>(0).fill(FREE_RAD);
        sigmas.fixed_rows_mut::<12>(THETA).copy_from_slice(theta_sigmas);
        sigmas.fixed_rows_mut::<3>(WHITE).fill(1.0);
        Self {
            estimate: SMatrix::zeros(),
            innovations: SMatrix::zeros(),
            covariance: SMatrix::from_diagonal(&sigmas.map(|s| s * s)),
        }
    }

    /// Takes away the knowledge that the vector sensors are perfect.
    pub fn doubt_vectors(&mut self, sigmas: &[VectorSigmas; 2]) {
        for (k, sigma) in sigmas.as_flattened().iter().enumerate() {
            self.covariance[(VECTORS + k, VECTORS + k)] = sigma * sigma;
        }
    }

    /// Covariance of theta = (P row-major, c).
    pub fn theta(&self) -> SMatrix<f64, 12, 12> {
        self.covariance.fixed_view::<12, 12>(THETA, THETA).into_owned()
    }

    /// Squared part of one set of readings that the state does not explain; for two sets, the product of
    /// those parts.
    pub fn unexplained(&self) -> &SMatrix<f64, N, N> {
        &self.innovations
    }

    /// Estimate of theta from the first set of readings.
    pub fn theta_estimate(&self) -> SVector<f64, 12> {
        self.estimate.fixed_view::<12, 1>(THETA, 0).into_owned()
    }

    /// Sets the estimate of theta to start from.
    pub fn set_theta_estimate(&mut self, theta: &SVector<f64, 12>) {
        self.estimate.fixed_view_mut::<12, 1>(THETA, 0).copy_from(theta);
    }

    /// Forgets the attitude, because the rotation was not measured.
    pub fn lose_attitude(&mut self) {
        self.add_noise(0, &Matrix3::from_diagonal_element(FREE_RAD * FREE_RAD));
    }

    /// Turns with `rate` over `step_s`. The attitude error turns the other way and gains the rate's error, dP
    /// raw - dc. `surprise` is the rate by the true model minus `rate`.
    pub fn turn(
        &mut self,
        rate_rad_s: &Vector3<f64>,
        raw_rad_s: &Vector3<f64>,
        surprise_rad_s: &SMatrix<f64, 3, N>,
        step_s: f64,
    ) {
        let whole = Rotation3::new(-rate_rad_s * step_s).into_inner();
        // Mean over the step of the rotations that remain to its end.
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
        let turned = whole * self.estimate.fixed_rows::<3>(0)
            + input * self.estimate.fixed_rows::<12>(THETA)
            + mean * surprise_rad_s;
        self.estimate.fixed_rows_mut::<3>(0).copy_from(&turned);
    }

    /// Adds noise to the three states from `first` on.
    pub fn add_noise(&mut self, first: usize, covariance: &Matrix3<f64>) {
        let mut block = self.covariance.fixed_view_mut::<3, 3>(first, first);
        block += covariance;
    }

    /// Observes rest: the reading is the bias, P^-1 (P raw - c) = noise. `surprise` is the rate by the true
    /// model.
    pub fn observe_rest(
        &mut self,
        inverse: &Matrix3<f64>,
        bias_rad_s: &Vector3<f64>,
        surprise_rad_s: &SMatrix<f64, 3, N>,
        sigma_rad_s: f64,
    ) {
        let surprise = -(inverse * surprise_rad_s);
        for axis in 0..3 {
            let mut row = SVector::<f64, STATES>::zeros();
            for i in 0..3 {
                for j in 0..3 {
                    row[THETA + 3 * i + j] = inverse[(axis, i)] * bias_rad_s[j];
                }
                row[C + i] = -inverse[(axis, i)];
            }
            self.observe(&row, sigma_rad_s, &surprise.row(axis).into_owned());
        }
    }

    /// Observes an earth-fixed vector whose true value in tool axes is `vector`, with vibration `shaken`
    /// (white - low), at a rate that a delay of the sensor needs. `surprise` is the reading minus `vector`.
    pub fn observe_vector(
        &mut self,
        (sensor, rate_rad_s): (VectorSensor, &Vector3<f64>),
        vector: &Vector3<f64>,
        surprise: &SMatrix<f64, 3, N>,
        shaken: &Vector3<f64>,
        sigmas: &Vector3<f64>,
    ) {
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
            let first = VECTORS + OF_A_VECTOR * sensor as usize;
            row.fixed_rows_mut::<3>(first + 3 * axis).copy_from(vector);
            row[first + 9 + axis] = 1.0;
            // A fixed vector turns against the tool: what is read was true a delay ago.
            row[first + 12] = rate_rad_s.cross(vector)[axis];
            self.observe(&row, sigmas[axis], &surprise.row(axis).into_owned());
        }
    }

    fn observe(&mut self, row: &SVector<f64, STATES>, sigma: f64, surprise: &SMatrix<f64, 1, N>) {
        let cross = self.covariance * row;
        let variance = cross.dot(row) + sigma * sigma;
        let innovation = surprise - row.transpose() * self.estimate;
        self.innovations += innovation.transpose() * innovation / variance;
        self.estimate += cross * (innovation / variance);
        self.covariance.ger(-1.0 / variance, &cross, &cross, 1.0);
    }

    /// The low-pass takes in this sample's white noise, and the next one is drawn.
    pub fn next_vibration(&mut self, smoothing: f64) {
        for axis in 0..3 {
            let (low, white) = (LOW + axis, WHITE + axis);
            let row = self.covariance.row(low) * (1.0 - smoothing) + self.covariance.row(white) * smoothing;
            self.covariance.set_row(low, &row);
            let column = self.covariance.column(low) * (1.0 - smoothing) + self.covariance.column(white) * smoothing;
            self.covariance.set_column(low, &column);
            self.covariance.row_mut(white).fill(0.0);
            self.covariance.column_mut(white).fill(0.0);
            self.covariance[(white, white)] = 1.0;
            let row = self.estimate.row(low) * (1.0 - smoothing) + self.estimate.row(white) * smoothing;
            self.estimate.set_row(low, &row);
            self.estimate.row_mut(white).fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known but for the scale factor about z: the angle between two readings of a field across the axis,
    /// over the angle turned.
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
            filter.observe_vector(
                (VectorSensor::Magnetometer, &rate),
                &body,
                &Vector3::zeros(),
                &Vector3::zeros(),
                &Vector3::repeat(sigma_ut),
            );
        };
        look(&mut filter, angle);
        for _ in 0..steps {
            filter.turn(&rate, &rate, &Vector3::zeros(), step_s);
            filter.add_noise(0, &Matrix3::from_diagonal_element((noise * step_s).powi(2)));
            angle += rate.z * step_s;
        }
        look(&mut filter, angle);
        let walked = noise * step_s * f64::from(steps).sqrt();
        let expected = (2.0 * (sigma_ut / field).powi(2) + walked * walked).sqrt() / angle;
        let found = filter.covariance[(THETA + 8, THETA + 8)].sqrt();
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
    }

    /// Readings that are what a theta other than the truth would give, in the linear model: the filter finds
    /// it.
    #[test]
    fn what_the_readings_hold_of_theta_is_found() {
        let mut filter = ErrorState::new(&[0.1; 12]);
        let field = Vector3::new(20.0, -10.0, 40.0);
        let sought = SVector::<f64, 12>::from_fn(|i, _| 1e-3 * ((i * 7 % 12) as f64 - 5.0));
        // a second filter that is not told carries the error of attitude that such a theta makes
        let mut carried = ErrorState::new(&[0.1; 12]);
        carried.set_theta_estimate(&sought);
        let mut angle = 0.0_f64;
        for k in 0..4_000 {
            let t = 0.01 * f64::from(k);
            let rate = Vector3::new(0.7 * (1.3 * t).sin(), 0.5 * (0.7 * t + 1.0).cos(), 1.0 + 0.8 * (0.4 * t).sin());
            filter.turn(&rate, &rate, &Vector3::zeros(), 0.01);
            carried.turn(&rate, &rate, &Vector3::zeros(), 0.01);
            angle += 0.01 * rate.norm();
            for vector in [field, Vector3::new(0.3 * angle.sin(), 0.2, 9.8)] {
                let turned: Vector3<f64> = carried.estimate.fixed_rows::<3>(0).into_owned();
                filter.observe_vector(
                    (VectorSensor::Magnetometer, &rate),
                    &vector,
                    &vector.cross(&turned),
                    &Vector3::zeros(),
                    &Vector3::repeat(1e-3),
                );
            }
        }
        let worst = (filter.theta_estimate() - sought).amax();
        assert!(worst < 1e-5, "{worst}");
    }

    /// With nothing but rest, c has the variance of a mean; with a walk it has the filter's known stationary
    /// value.
    #[test]
    fn a_rest_gives_the_bias_as_a_mean_does() {
        let mut filter: ErrorState =
            ErrorState::new(&[1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1.0, 1.0, 1.0]);
        for _ in 0..1_000 {
            filter.observe_rest(&Matrix3::identity(), &Vector3::new(0.02, -0.01, 0.03), &Vector3::zeros(), 2e-3);
        }
        let found = filter.covariance[(C, C)].sqrt();
        assert!((found / (2e-3 / 1_000_f64.sqrt()) - 1.0).abs() < 1e-3, "{found}");
        // Walk q a step, reading r: before each reading the variance is (q^2 + sqrt(q^4 + 4 q^2 r^2)) / 2.
        let (q, r) = (1e-4_f64, 2e-3_f64);
        for _ in 0..10_000 {
            filter.observe_rest(&Matrix3::identity(), &Vector3::zeros(), &Vector3::zeros(), r);
            filter.add_noise(C, &Matrix3::from_diagonal_element(q * q));
        }
        let expected = 0.5 * (q * q + (q.powi(4) + 4.0 * q * q * r * r).sqrt());
        assert!((filter.covariance[(C, C)] / expected - 1.0).abs() < 1e-6);
    }

    /// The mean of high-passed noise averages out faster than white noise: its sum is the low-pass's lag,
    /// which is bounded.
    #[test]
    fn vibration_without_a_slow_part_leaves_a_mean_that_falls_with_the_time() {
        let sigma = |samples: usize| {
            let mut filter = ErrorState::new(&[1e-9; 12]);
            for _ in 0..samples {
                let (down, shaken) = (Vector3::new(0.0, 0.0, 9.8), Vector3::repeat(3.0));
                filter.observe_vector(
                    (VectorSensor::Accelerometer, &Vector3::zeros()),
                    &down,
                    &Vector3::zeros(),
                    &shaken,
                    &Vector3::repeat(1e-3),
                );
                filter.next_vibration(0.12);
            }
            filter.covariance[(0, 0)].sqrt()
        };
        let ratio = sigma(200) / sigma(1_600);
        assert!(ratio > 7.0, "white noise would give the square root of 8: {ratio}");
    }

    /// A delay and an offset that nobody knows leave as much of two angles as the prior says.
    #[test]
    fn an_unknown_delay_makes_a_steady_rotation_worthless_and_a_known_one_does_not() {
        let rate = Vector3::new(0.0, 0.0, 1.5);
        let sigma = |delay_s: f64| {
            let mut filter: ErrorState = ErrorState::new(&[1e-9; 12]);
            let mut of_field = [0.0; 13];
            of_field[12] = delay_s;
            filter.doubt_vectors(&[[0.0; 13], of_field]);
            for k in 0..500 {
                let angle = 0.015 * f64::from(k);
                let body = Vector3::new(50.0 * angle.cos(), -50.0 * angle.sin(), 0.0);
                let sensor = (VectorSensor::Magnetometer, &rate);
                filter.observe_vector(sensor, &body, &Vector3::zeros(), &Vector3::zeros(), &Vector3::repeat(1e-3));
                filter.turn(&rate, &rate, &Vector3::zeros(), 0.01);
            }
            filter.covariance[(2, 2)].sqrt()
        };
        assert!((sigma(0.01) / 0.015 - 1.0).abs() < 1e-3, "{}", sigma(0.01));
        assert!(sigma(0.0) < 1e-5);
    }
}
