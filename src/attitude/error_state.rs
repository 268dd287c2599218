//! Covariance of the error state, and the scalar Kalman update of the attitude filter.

#![allow(clippy::indexing_slicing)] // constant sizes, indices from loops over them

mod scale;

use nalgebra::{Matrix3, Vector2, Vector3};
use scale::ScaleErrors;

/// Number of states beside the gyro's scale: attitude error phi (3, NED, radians, `C_true = exp(phi) C`), gyro bias
/// error (3, body, rad/s), horizontal velocity error (2, north and east, m/s).
pub(crate) const STATES: usize = 8;
/// Index of the first bias state.
pub(crate) const BIAS: usize = 3;
/// Index of the first velocity state.
pub(crate) const VELOCITY: usize = 6;
/// Number of errors of the gyro's scale: factors and couplings, 3x3, row-major.
pub(crate) const SCALES: usize = 9;
/// Index of the attitude error about the vertical.
pub(crate) const HEADING: usize = 2;

/// States that an update may correct.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gain {
    /// Every state: the optimal gain.
    Every,
    /// The heading and these axes of the bias only, so that a disturbed field never tilts the estimate. The covariance
    /// is updated for this gain.
    Heading([bool; 3]),
}

impl Gain {
    /// Returns true if the gyro's scale is corrected: with any axis of the bias.
    fn moves_scale(self) -> bool {
        match self {
            Self::Every => true,
            Self::Heading(bias) => bias.contains(&true),
        }
    }

    fn moves(self, state: usize) -> bool {
        match self {
            Self::Every => true,
            Self::Heading(bias) => {
                state == HEADING || state >= BIAS && bias.get(state - BIAS).is_some_and(|moves| *moves)
            }
        }
    }
}

/// Process noise of one filter step, variances.
pub(crate) struct ProcessNoise {
    /// Attitude error, NED, rad^2.
    pub(crate) attitude: Matrix3<f32>,
    /// Each axis of the bias, (rad/s)^2.
    pub(crate) bias: f32,
    /// Noise of each axis of the bias from a bounded source, (rad/s)^2: the variance that it adds, and the variance of
    /// the bias from which on it adds none.
    pub(crate) bounded_bias: [f32; 2],
    /// Each horizontal velocity, (m/s)^2.
    pub(crate) velocity: f32,
    /// Each error of the gyro's scale, dimensionless, where these errors are states.
    pub(crate) scale: f32,
}

/// Error-state Kalman filter: the covariance, and the correction collected by updates since
/// [`ErrorState::take_correction`].
///
/// Only the upper triangle (column at least row) of the covariance is kept; elements below it are never read.
#[derive(Clone, Copy)]
pub(crate) struct ErrorState {
    covariance: [[f32; STATES]; STATES],
    correction: [f32; STATES],
    scale: ScaleErrors,
}

impl ErrorState {
    pub(crate) const fn new() -> Self {
        Self { covariance: [[0.0; STATES]; STATES], correction: [0.0; STATES], scale: ScaleErrors::NONE }
    }

    /// Variance of one state.
    pub(crate) const fn variance(&self, state: usize) -> f32 {
        self.covariance[state][state]
    }

    /// Covariance of the attitude error, rad^2, NED.
    pub(crate) fn attitude_covariance(&self) -> Matrix3<f32> {
        let [[xx, xy, xz, ..], [_, yy, yz, ..], [_, _, zz, ..], ..] = self.covariance;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Resets a state to a variance, uncorrelated with all others. Not inlined: its copies would take a
    /// kilobyte of flash.
    #[inline(never)]
    pub(crate) fn reset(&mut self, state: usize, variance: f32) {
        // An index beyond the states changes nothing. The check keeps a panic unreachable.
        let Some(row) = self.covariance.get_mut(state) else { return };
        *row = [0.0; STATES];
        self.scale.forget(state);
        for row in &mut self.covariance {
            if let Some(element) = row.get_mut(state) {
                *element = 0.0;
            }
        }
        if let Some(element) = self.covariance.get_mut(state).and_then(|row| row.get_mut(state)) {
            *element = variance;
        }
    }

    /// Resets the attitude error to a covariance, NED, rad^2, uncorrelated with all others.
    pub(crate) fn reset_attitude(&mut self, covariance: &Matrix3<f32>) {
        for axis in 0..BIAS {
            self.reset(axis, covariance[(axis, axis)]);
        }
        for (row, column) in [(0, 1), (0, 2), (1, 2)] {
            self.covariance[row][column] = covariance[(row, column)];
        }
    }

    /// Resets the tilt to a covariance, NED, rad^2, uncorrelated with all other states.
    pub(crate) fn reset_tilt(&mut self, covariance: &Matrix3<f32>) {
        self.reset(0, covariance.m11);
        self.reset(1, covariance.m22);
        self.covariance[0][1] = covariance.m12;
    }

    /// Inflates the variance of a state, up to a limit at which the state is reset.
    pub(crate) fn inflate(&mut self, state: usize, variance: f32, limit: f32) {
        let sum = self.covariance[state][state] + variance;
        if sum < limit {
            self.covariance[state][state] = sum;
        } else {
            self.reset(state, limit);
        }
    }

    /// Predicts the errors over a step: phi' = -C db and, while gravity is seen, dv' = phi x (0, 0, -g).
    /// `rotation_time` is the integral of C (body to NED) over the step, seconds; `gravity_time` that of g,
    /// m/s, 0 if no specific force was read. `rate` is the step's mean body rate, by which the errors of the gyro's
    /// scale turn the attitude, rad/s.
    pub(crate) fn predict(
        &mut self,
        rotation_time: &Matrix3<f32>,
        gravity_time: f32,
        rate: &Vector3<f32>,
        noise: &ProcessNoise,
    ) {
        self.predict_base(rotation_time, gravity_time, noise);
        if self.scale.is_estimated() {
            self.scale.predict(&mut self.covariance, rotation_time, gravity_time, rate, noise.scale);
        }
    }

    /// Predicts all states but the errors of the gyro's scale.
    fn predict_base(&mut self, rotation_time: &Matrix3<f32>, gravity_time: f32, noise: &ProcessNoise) {
        let p = &mut self.covariance;
        let turn = |r: usize, k: usize| rotation_time[(r, k)];
        // Covariances of the attitude with itself, bias and velocity, each after the turn by the bias error.
        let mut attitude_bias = [[0.0; 3]; 3];
        let mut attitude = [[0.0; 3]; 3];
        let mut attitude_velocity = [[0.0; 2]; 3];
        for r in 0..3 {
            for c in 0..3 {
                let old = |k: usize| p[r][BIAS + k];
                attitude[r][c] = (if r < c { p[r][c] } else { p[c][r] })
                    - (turn(r, 0) * p[c][BIAS] + turn(r, 1) * p[c][BIAS + 1] + turn(r, 2) * p[c][BIAS + 2]);
                let bias = |k: usize| if k < c { p[BIAS + k][BIAS + c] } else { p[BIAS + c][BIAS + k] };
                attitude_bias[r][c] = old(c) - (turn(r, 0) * bias(0) + turn(r, 1) * bias(1) + turn(r, 2) * bias(2));
            }
            for c in 0..2 {
                let bias = |k: usize| p[BIAS + k][VELOCITY + c];
                attitude_velocity[r][c] =
                    p[r][VELOCITY + c] - (turn(r, 0) * bias(0) + turn(r, 1) * bias(1) + turn(r, 2) * bias(2));
            }
        }
        let g = gravity_time;
        p[VELOCITY][VELOCITY] += g * (g * p[1][1] - 2.0 * p[1][VELOCITY]) + noise.velocity;
        p[VELOCITY][VELOCITY + 1] += g * (p[0][VELOCITY] - p[1][VELOCITY + 1] - g * p[0][1]);
        p[VELOCITY + 1][VELOCITY + 1] += g * (g * p[0][0] + 2.0 * p[0][VELOCITY + 1]) + noise.velocity;
        for k in 0..3 {
            p[BIAS + k][VELOCITY] -= g * p[1][BIAS + k];
            p[BIAS + k][VELOCITY + 1] += g * p[0][BIAS + k];
            let [bounded, most] = noise.bounded_bias;
            p[BIAS + k][BIAS + k] += noise.bias + if p[BIAS + k][BIAS + k] < most { bounded } else { 0.0 };
        }
        for r in 0..3 {
            p[r][VELOCITY] = attitude_velocity[r][0] - g * attitude[r][1];
            p[r][VELOCITY + 1] = attitude_velocity[r][1] + g * attitude[r][0];
            for c in 0..3 {
                p[r][BIAS + c] = attitude_bias[r][c];
                if c >= r {
                    let carried = attitude_bias[r][0] * turn(c, 0)
                        + attitude_bias[r][1] * turn(c, 1)
                        + attitude_bias[r][2] * turn(c, 2);
                    p[r][c] = attitude[r][c] - carried + noise.attitude[(r, c)];
                }
            }
        }
    }

    /// Updates by a direct observation of one state's error.
    pub(crate) fn update(&mut self, state: usize, innovation: f32, variance: f32, gain: Gain) {
        let column = self.column(state);
        let of_scale = self.scale.column(state);
        self.update_scalar(&column, &of_scale, column[state] + variance, innovation - self.correction[state], gain);
    }

    /// Updates by an observation of the heading's error to which tilt errors about north and east add by
    /// `slope`.
    pub(crate) fn update_heading(&mut self, innovation: f32, slope: &Vector2<f32>, variance: f32, gain: Gain) {
        let (north, east) = (self.column(0), self.column(1));
        let mut column = self.column(HEADING);
        for (k, element) in column.iter_mut().enumerate() {
            *element += slope.x * north[k] + slope.y * east[k];
        }
        let seen = |x: &[f32; STATES]| x[HEADING] + slope.x * x[0] + slope.y * x[1];
        let residual = innovation - seen(&self.correction);
        let of_scale = self.scale.heading_column(slope);
        self.update_scalar(&column, &of_scale, seen(&column) + variance, residual, gain);
    }

    /// Variance of the heading that a field observes, rad^2; tilt errors about north and east add to this heading by
    /// `slope`.
    pub(crate) fn seen_heading_variance(&self, slope: &Vector2<f32>) -> f32 {
        let p = &self.covariance;
        let about_north = slope.x * p[0][0] + 2.0 * (slope.y * p[0][1] + p[0][HEADING]);
        p[HEADING][HEADING] + slope.x * about_north + slope.y * (slope.y * p[1][1] + 2.0 * p[1][HEADING])
    }

    fn column(&self, state: usize) -> [f32; STATES] {
        let mut column = [0.0; STATES];
        for (other, element) in column.iter_mut().enumerate() {
            *element = if other < state { self.covariance[other][state] } else { self.covariance[state][other] };
        }
        column
    }

    /// Starts to estimate the errors of the gyro's scale (row-major), with these deviations.
    pub(crate) fn estimate_scale(&mut self, deviations: &[f32; SCALES]) {
        self.scale = ScaleErrors::new(deviations);
    }

    /// Ends the estimate of the scale's errors.
    pub(crate) const fn leave_scale(&mut self) {
        self.scale = ScaleErrors::NONE;
    }

    /// Returns true while the scale's errors are states.
    pub(crate) const fn estimates_scale(&self) -> bool {
        self.scale.is_estimated()
    }

    /// Sum of the variances of the scale's three errors by which a rate about one axis is wrong; 0 where they are not
    /// estimated.
    pub(crate) fn scale_variance_of_axis(&self, axis: usize) -> f32 {
        self.scale.variance(axis) + self.scale.variance(axis + 3) + self.scale.variance(axis + 6)
    }

    /// Updates by a direct observation of one of the scale's errors. A negative variance takes out an observation that
    /// was made before.
    pub(crate) fn update_scale(&mut self, element: usize, innovation: f32, variance: f32) {
        let (column, of_scale) = self.scale.own_column(element);
        let residual = innovation - self.scale.correction(element);
        let seen = of_scale.get(element).copied().unwrap_or(0.0);
        self.update_scalar(&column, &of_scale, seen + variance, residual, Gain::Every);
    }

    /// Replaces the prior of the scale's errors, of deviation `sigma` about zero, by wider ones of factors and
    /// couplings, as if they had held from the start; the errors must not have walked since. `errors` are those before
    /// the collected correction. Returns the log Bayes factor of the wider ones; NaN if an error is less certain than
    /// by its prior, to f32's precision.
    ///
    /// An error x of variance v becomes by a deviation w in place of s more probable by the factor
    /// `s/w (1 - a v)^(-1/2) exp(a x^2 / 2 (1 - a v))`, where a = 1/s^2 - 1/w^2; the elements are widened one by one.
    pub(crate) fn widen_scale(&mut self, errors: &Matrix3<f32>, sigma: f32, [factor, coupling]: [f32; 2]) -> f32 {
        let mut log_bayes_factor = 0.0;
        for k in 0..SCALES {
            let (row, column) = (k / 3, k % 3);
            let wide = if row == column { factor } else { coupling };
            if wide <= sigma {
                continue;
            }
            let a = 1.0 / (sigma * sigma) - 1.0 / (wide * wide);
            let before = errors[(row, column)];
            let (x, left) = (before + self.scale.correction(k), 1.0 - a * self.scale.variance(k));
            // As much is left of an error that was never observed.
            let unobserved = (sigma / wide) * (sigma / wide);
            if left.is_nan() || left <= 0.5 * unobserved {
                return f32::NAN;
            }
            log_bayes_factor += libm::logf(sigma / wide) + 0.5 * (a * x * x / left - libm::logf(left));
            // A negative variance takes out what the narrower prior says beyond the wider one.
            self.update_scale(k, -before, -1.0 / a);
        }
        log_bayes_factor
    }

    /// Scalar Kalman update for an observation h of the errors: `column` and `of_scale` are P h', `total` the
    /// innovation's variance, negative where an observation is taken out, `residual` the innovation less the collected
    /// correction.
    ///
    /// With the optimal gain k = P h' / total the covariance loses P h' h P / total. With some gains set to
    /// zero, `(I - K h) P (I - K h)' + R K K'` loses the same, but nothing between two states whose gains are
    /// zero.
    #[inline(never)]
    fn update_scalar(
        &mut self,
        column: &[f32; STATES],
        of_scale: &[f32; SCALES],
        total: f32,
        residual: f32,
        gain: Gain,
    ) {
        // A NaN updates nothing.
        if total == 0.0 || total.is_nan() {
            return;
        }
        let weight = 1.0 / total;
        if self.scale.is_estimated() {
            self.scale.update(column, of_scale, weight, residual, gain);
        }
        let mut k = column.map(|element| element * weight);
        if gain == Gain::Every {
            self.correction.iter_mut().zip(&k).for_each(|(correction, k)| *correction += k * residual);
            let [p0, p1, p2, p3, p4, p5, p6, p7] = &mut self.covariance;
            let [k0, k1, k2, k3, k4, k5, k6, k7] = k;
            less_products::<0>(p0, k0, column);
            less_products::<1>(p1, k1, column);
            less_products::<2>(p2, k2, column);
            less_products::<3>(p3, k3, column);
            less_products::<4>(p4, k4, column);
            less_products::<5>(p5, k5, column);
            less_products::<6>(p6, k6, column);
            less_products::<7>(p7, k7, column);
            return;
        }
        for (state, k) in k.iter_mut().enumerate() {
            *k = if gain.moves(state) { *k } else { 0.0 };
        }
        for r in 0..STATES {
            self.correction[r] += k[r] * residual;
            let (one, other) = if gain.moves(r) { (k[r], column) } else { (column[r], &k) };
            #[allow(clippy::needless_range_loop)] // with iterators it takes twice the instructions
            for c in r..STATES {
                self.covariance[r][c] -= one * other[c];
            }
        }
    }

    /// Takes the collected correction (attitude, bias, velocity, scale) and zeroes it.
    pub(crate) fn take_correction(&mut self) -> (Vector3<f32>, Vector3<f32>, Vector2<f32>, Matrix3<f32>) {
        let x = self.correction;
        self.correction = [0.0; STATES];
        (
            Vector3::new(x[0], x[1], x[2]),
            Vector3::new(x[3], x[4], x[5]),
            Vector2::new(x[6], x[7]),
            self.scale.take_correction(),
        )
    }

    /// Returns true if every number is finite and every variance positive.
    pub(crate) fn is_sound(&self) -> bool {
        // A single number that is not finite makes the sum not finite.
        let mut sum = 0.0;
        for r in 0..STATES {
            sum += self.correction[r];
            for c in r..STATES {
                sum += self.covariance[r][c];
            }
        }
        sum.is_finite() && self.scale.is_sound() && (0..STATES).all(|i| self.covariance[i][i] > 0.0)
    }
}

/// Subtracts a gain times a column from a row, from the diagonal on. The compiler knows the length, so that the column
/// stays in registers.
#[inline(always)]
fn less_products<const FROM: usize>(row: &mut [f32; STATES], gain: f32, column: &[f32; STATES]) {
    #[allow(clippy::needless_range_loop)] // with iterators it takes twice the instructions
    for c in FROM..STATES {
        row[c] -= gain * column[c];
    }
}

#[cfg(test)]
mod tests;
