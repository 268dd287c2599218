#![allow(clippy::indexing_slicing)] // constant sizes, indices from loops over them

use nalgebra::{Matrix3, Vector2, Vector3};

/// Attitude error phi (3, NED, radians, `C_true = exp(phi) C`), gyro bias error (3, body, rad/s), horizontal velocity error
/// (2, north and east, m/s).
pub(crate) const STATES: usize = 8;
/// First bias state.
pub(crate) const BIAS: usize = 3;
/// First velocity state.
pub(crate) const VELOCITY: usize = 6;
/// The attitude state about the vertical.
pub(crate) const HEADING: usize = 2;

/// Which states a measurement may move.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gain {
    /// All of them: the optimal gain.
    Every,
    /// Heading and bias only, so that a disturbed field never tilts the estimate; the covariance stays that of the gain used.
    HeadingAndBias,
    /// Heading alone: where no gravity is seen, a tilt error in the field would be taken for a bias.
    Heading,
}

impl Gain {
    fn moves(self, state: usize) -> bool {
        match self {
            Self::Every => true,
            Self::HeadingAndBias => (HEADING..VELOCITY).contains(&state),
            Self::Heading => state == HEADING,
        }
    }
}

/// How much the states spread over a step, in variance.
pub(crate) struct Spread {
    /// Attitude, NED, rad^2.
    pub(crate) attitude: Matrix3<f32>,
    /// Each bias, (rad/s)^2.
    pub(crate) bias: f32,
    /// Each velocity, (m/s)^2.
    pub(crate) velocity: f32,
}

/// Covariance of the filter's errors and the correction collected since it was last taken.
///
/// Only the upper triangle (column at least row) is kept; what lies below it is never read.
pub(crate) struct ErrorState {
    covariance: [[f32; STATES]; STATES],
    correction: [f32; STATES],
}

impl ErrorState {
    pub(crate) const fn new() -> Self {
        Self { covariance: [[0.0; STATES]; STATES], correction: [0.0; STATES] }
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

    /// Gives a state a variance of its own, independent of all others. Out of line: copies of it would be a kilobyte of flash.
    #[inline(never)]
    pub(crate) fn open(&mut self, state: usize, variance: f32) {
        // Beyond the states there is nothing to open; said so that no panic can be reached.
        let Some(row) = self.covariance.get_mut(state) else { return };
        *row = [0.0; STATES];
        for row in &mut self.covariance {
            if let Some(element) = row.get_mut(state) {
                *element = 0.0;
            }
        }
        if let Some(element) = self.covariance.get_mut(state).and_then(|row| row.get_mut(state)) {
            *element = variance;
        }
    }

    /// Adds to the variance of a state, up to a limit.
    pub(crate) fn widen(&mut self, state: usize, variance: f32, limit: f32) {
        let sum = self.covariance[state][state] + variance;
        if sum < limit {
            self.covariance[state][state] = sum;
        } else {
            self.open(state, limit);
        }
    }

    /// Carries the errors over a step: phi' = -C db, and, while gravity is `gravity_m_s2`, dv' = phi x (0, 0, -g).
    /// `rotation_time` is the integral of C (body to NED) over the step, seconds; `gravity_time` that of g, m/s, 0 when the
    /// specific force was not seen.
    pub(crate) fn propagate(&mut self, rotation_time: &Matrix3<f32>, gravity_time: f32, spread: &Spread) {
        let p = &mut self.covariance;
        let turn = |r: usize, k: usize| rotation_time[(r, k)];
        // attitude against bias, then attitude against velocity, each less what the bias turns it by
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
        p[VELOCITY][VELOCITY] += g * (g * p[1][1] - 2.0 * p[1][VELOCITY]) + spread.velocity;
        p[VELOCITY][VELOCITY + 1] += g * (p[0][VELOCITY] - p[1][VELOCITY + 1] - g * p[0][1]);
        p[VELOCITY + 1][VELOCITY + 1] += g * (g * p[0][0] + 2.0 * p[0][VELOCITY + 1]) + spread.velocity;
        for k in 0..3 {
            p[BIAS + k][VELOCITY] -= g * p[1][BIAS + k];
            p[BIAS + k][VELOCITY + 1] += g * p[0][BIAS + k];
            p[BIAS + k][BIAS + k] += spread.bias;
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
                    p[r][c] = attitude[r][c] - carried + spread.attitude[(r, c)];
                }
            }
        }
    }

    /// Takes in a direct reading of one state's error, with its variance.
    ///
    /// With the column h of that state in P, s = h_state + variance and the optimal gain k = h / s, the covariance loses h h' / s. Where
    /// the gain of a state is set to zero, `(I - K h) P (I - K h)' + R K K'` loses the same, save between two such states: nothing.
    #[inline(never)]
    pub(crate) fn observe(&mut self, state: usize, innovation: f32, variance: f32, gain: Gain) {
        let mut column = [0.0; STATES];
        for (other, element) in column.iter_mut().enumerate() {
            *element = if other < state { self.covariance[other][state] } else { self.covariance[state][other] };
        }
        let total = column[state] + variance;
        if total <= 0.0 {
            return;
        }
        let (residual, weight) = (innovation - self.correction[state], 1.0 / total);
        let mut k = column.map(|element| element * weight);
        if gain != Gain::Every {
            for (state, k) in k.iter_mut().enumerate() {
                *k = if gain.moves(state) { *k } else { 0.0 };
            }
        }
        for r in 0..STATES {
            self.correction[r] += k[r] * residual;
            let (one, other) = if gain.moves(r) { (k[r], &column) } else { (column[r], &k) };
            #[allow(clippy::needless_range_loop)] // with iterators it takes twice the instructions
            for c in r..STATES {
                self.covariance[r][c] -= one * other[c];
            }
        }
    }

    /// The correction collected (attitude, bias, velocity), which is then zero again.
    pub(crate) fn take_correction(&mut self) -> (Vector3<f32>, Vector3<f32>, Vector2<f32>) {
        let x = self.correction;
        self.correction = [0.0; STATES];
        (Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]), Vector2::new(x[6], x[7]))
    }

    /// Whether every number is finite and every variance positive.
    pub(crate) fn is_sound(&self) -> bool {
        // of finite numbers zero, of others not a number
        let mut zero = 0.0;
        for r in 0..STATES {
            zero += 0.0 * self.correction[r];
            for c in r..STATES {
                zero += 0.0 * self.covariance[r][c];
            }
        }
        zero == 0.0 && (0..STATES).all(|i| self.covariance[i][i] > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::exp_matrix;
    use nalgebra::SMatrix;

    type Dense = SMatrix<f64, STATES, STATES>;

    fn dense(e: &ErrorState) -> Dense {
        Dense::from_fn(|r, c| f64::from(e.covariance[r.min(c)][r.max(c)]))
    }

    fn started() -> ErrorState {
        let mut e = ErrorState::new();
        for (state, variance) in [0.01, 0.02, 1.0, 4e-4, 4e-4, 4e-4, 0.25, 0.25].into_iter().enumerate() {
            e.open(state, variance);
        }
        e
    }

    fn spread() -> Spread {
        Spread { attitude: Matrix3::from_diagonal(&Vector3::new(1e-5, 2e-5, 3e-5)), bias: 1e-9, velocity: 1e-5 }
    }

    #[test]
    fn a_step_is_the_dense_product() {
        let mut e = started();
        let mut expected = dense(&e);
        for i in 0..50_u8 {
            let c = exp_matrix(&Vector3::new(0.1 * f32::from(i), 0.3, -0.2)) * 0.02;
            let mut f = Dense::identity();
            for r in 0..3 {
                for k in 0..3 {
                    f[(r, BIAS + k)] = -f64::from(c[(r, k)]);
                }
            }
            f[(VELOCITY, 1)] = -0.196;
            f[(VELOCITY + 1, 0)] = 0.196;
            let mut q = Dense::zeros();
            for (k, x) in [1e-5, 2e-5, 3e-5, 1e-9, 1e-9, 1e-9, 1e-5, 1e-5].into_iter().enumerate() {
                q[(k, k)] = x;
            }
            expected = f * expected * f.transpose() + q;
            e.propagate(&c, 0.196, &spread());
        }
        assert!((dense(&e) - expected).norm() < 1e-5 * expected.norm());
    }

    #[test]
    fn an_optimal_and_a_restricted_gain_agree_with_the_dense_joseph_form() {
        for gain in [Gain::Every, Gain::HeadingAndBias, Gain::Heading] {
            let mut e = started();
            for _ in 0..20 {
                e.propagate(&(exp_matrix(&Vector3::new(0.5, 0.2, 0.1)) * 0.02), 0.196, &spread());
            }
            let p = dense(&e);
            let mut h = SMatrix::<f64, 1, STATES>::zeros();
            h[HEADING] = 1.0;
            let variance = 0.3_f32;
            let mut k = p * h.transpose() / (p[(HEADING, HEADING)] + f64::from(variance));
            let still: &[usize] = match gain {
                Gain::Every => &[],
                Gain::HeadingAndBias => &[0, 1, 6, 7],
                Gain::Heading => &[0, 1, 3, 4, 5, 6, 7],
            };
            still.iter().for_each(|i| k[*i] = 0.0);
            let rest = Dense::identity() - k * h;
            let expected = rest * p * rest.transpose() + k * k.transpose() * f64::from(variance);
            e.observe(HEADING, 0.2, variance, gain);
            assert!((dense(&e) - expected).norm() < 1e-5 * expected.norm());
            let (attitude, _, velocity) = e.take_correction();
            assert!((f64::from(attitude.z) - 0.2 * k[HEADING]).abs() < 1e-6);
            assert_eq!(gain != Gain::Every, attitude.xy().norm() == 0.0 && velocity.norm() == 0.0);
        }
    }

    #[test]
    fn an_hour_keeps_the_covariance_positive_definite() {
        let mut e = started();
        for i in 0..180_000_u32 {
            let angle = f32::from(u16::try_from(i % 6_283).unwrap_or(0)) * 0.001;
            e.propagate(&(exp_matrix(&Vector3::new(0.3, angle, -2.0 * angle)) * 0.02), 0.196, &spread());
            e.observe(VELOCITY, 0.0, 7.5, Gain::Every);
            e.observe(VELOCITY + 1, 0.0, 7.5, Gain::Every);
            e.observe(HEADING, 0.0, 2.0, Gain::HeadingAndBias);
            if i % 3_000 < 500 {
                (BIAS..VELOCITY).for_each(|k| e.observe(k, 0.0, 1e-5, Gain::Every));
            }
        }
        assert!(e.is_sound() && dense(&e).cholesky().is_some());
    }
}
