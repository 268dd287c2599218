//! Filter of the field in the gyro's frame, with 19 states (docs/magnets.md).

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::field_node::{FieldNode, GYRO};
use crate::{
    algebra::{Packed, Whitening},
    rotation::{exp_quaternion, rotate_back},
};
use nalgebra::{Matrix3, Vector3};

/// Number of states: the gyro's errors, the magnetometer's lag, the body's iron, the earth's field.
pub(super) const STATES: usize = IN_EARTH + 3;
const PACKED: usize = STATES * (STATES + 1) / 2;
/// Index of the magnetometer's lag behind the gyro, seconds; it follows the gyro's errors.
pub(super) const LAG: usize = GYRO;
/// Index of the body-fixed offset, microtesla.
pub(super) const IN_BODY: usize = LAG + 1;
/// Index of the earth's field in the frame that the nominal gyro carries along, microtesla.
pub(super) const IN_EARTH: usize = IN_BODY + 3;

/// Initial deviations of the states in their units, and their process noise. Those of the earth's field follow from the
/// iron's.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldPrior {
    pub diagonal: f32,
    pub off_diagonal: f32,
    pub bias_rad_s: f32,
    pub lag_s: f32,
    pub in_body_ut: f32,
    /// Time in which the variance of P, lag and iron grows by its initial value, seconds.
    pub forgetting_s: f32,
    pub bias_walk_rad_s_rts: f32,
}

impl FieldPrior {
    pub const fn zero() -> Self {
        Self {
            diagonal: 0.0,
            off_diagonal: 0.0,
            bias_rad_s: 0.0,
            lag_s: 0.0,
            in_body_ut: 0.0,
            forgetting_s: 0.0,
            bias_walk_rad_s_rts: 0.0,
        }
    }

    fn sigma(&self, state: usize) -> f32 {
        match state {
            0 | 4 | 8 => self.diagonal,
            1..9 => self.off_diagonal,
            9..LAG => self.bias_rad_s,
            LAG => self.lag_s,
            _ => self.in_body_ut,
        }
    }
}

/// Kalman filter of the magnetic field in the frame that the nominal gyro carries along. Reading m, earth's field B,
/// body-fixed offset h, lag tau, rate w: R0 m = B + R0 h + tau R0 (w x (m - h)). An error dw of the nominal rate turns
/// B by B' = B x (R0 dw), and dw is linear in the errors of P and bias, which are states. So a P that is wrong by
/// percents and not yet identified explains its own effect on B, and nothing else.
#[derive(Clone, Copy)]
pub(super) struct FieldFilter {
    x: [f32; STATES],
    covariance: Packed<STATES, PACKED>,
}

/// Innovation of a node against a filter's prediction.
pub(super) struct Innovation {
    pub innovation_ut: Vector3<f32>,
    /// Covariance times each row of the observation matrix.
    projected: [[f32; STATES]; 3],
    /// Covariance of the prediction without the node's own noise, microtesla squared.
    pub predicted: Matrix3<f32>,
}

impl Innovation {
    /// Returns the normalised innovation squared, and the log determinant of its covariance over the noise's,
    /// for a noise of variance `noise` on each axis; `None` if the covariance is not positive definite.
    pub fn squared(&self, noise: f32) -> Option<(f32, f32)> {
        let covariance = self.predicted + Matrix3::from_diagonal_element(noise);
        let whitening = Whitening::new(&covariance)?;
        let squared = whitening.apply(&self.innovation_ut).norm_squared();
        Some((squared, whitening.log_determinant() - 3.0 * libm::logf(noise)))
    }
}

impl FieldFilter {
    pub const fn zero() -> Self {
        Self { x: [0.0; STATES], covariance: Packed::zero() }
    }

    /// Resets the filter to its prior; the earth's field is `field_ut`, with twice the iron's deviation.
    pub fn start(&mut self, field_ut: &Vector3<f32>, prior: &FieldPrior) {
        *self = Self::zero();
        for state in 0..IN_EARTH {
            let sigma = prior.sigma(state);
            self.covariance.add(state, state, sigma * sigma);
        }
        for k in 0..3 {
            self.x[IN_EARTH + k] = field_ut[k];
        }
        self.inflate(IN_EARTH, 2.0 * prior.in_body_ut);
    }

    pub fn in_body(&self) -> Vector3<f32> {
        Vector3::new(self.x[IN_BODY], self.x[IN_BODY + 1], self.x[IN_BODY + 2])
    }

    pub fn in_body_variances_ut2(&self) -> Vector3<f32> {
        self.in_body_covariance().diagonal()
    }

    pub fn in_body_covariance(&self) -> Matrix3<f32> {
        Matrix3::from_fn(|i, j| self.covariance.get(IN_BODY + i, IN_BODY + j))
    }

    pub fn in_earth(&self) -> Vector3<f32> {
        Vector3::new(self.x[IN_EARTH], self.x[IN_EARTH + 1], self.x[IN_EARTH + 2])
    }

    #[cfg(test)]
    pub fn lag_s(&self) -> f32 {
        self.x[LAG]
    }

    /// Inflates the three states from `first` on: they may have jumped by `sigma`.
    pub fn inflate(&mut self, first: usize, sigma: f32) {
        for state in first..first + 3 {
            self.covariance.add(state, state, sigma * sigma);
        }
    }

    /// Resets the bias error to zero with a deviation of `sigma_rad_s`, after rests gave the bias.
    pub fn set_bias(&mut self, sigma_rad_s: f32) {
        for state in 9..LAG {
            self.x[state] = 0.0;
            for other in 0..STATES {
                let value = self.covariance.get(state, other);
                self.covariance.add(state, other, -value);
            }
            self.covariance.add(state, state, sigma_rad_s * sigma_rad_s);
        }
    }

    /// Shifts the bias error by a change of the bias that is subtracted before the filter.
    pub fn shift_bias(&mut self, change: &Vector3<f32>) {
        for k in 0..3 {
            self.x[9 + k] -= change[k];
        }
    }

    pub fn bias_variance(&self) -> f32 {
        (9..LAG).map(|state| self.covariance.get(state, state)).fold(0.0, |sum, x| sum + x) / 3.0
    }

    /// Predicts over a node's time: B turns by the frame's error. `walk_ut2` is the process noise of the
    /// earth's field.
    pub fn predict(&mut self, node: &FieldNode, prior: &FieldPrior, walk_ut2: f32) {
        let field = self.in_earth();
        let mut wrong_turn = Vector3::zeros();
        // Rows of d(B after) / d(errors of the gyro): B x (turn).
        let mut gain = [[0.0; STATES]; 3];
        for error in 0..GYRO {
            let turn = Vector3::new(node.turn[0][error], node.turn[1][error], node.turn[2][error]);
            wrong_turn += turn * self.x[error];
            let moved = field.cross(&turn);
            for i in 0..3 {
                gain[i][error] = moved[i];
            }
        }
        let turned = rotate_back(&exp_quaternion(&wrong_turn), &field);
        let carried = self.covariance.times_within(&gain, 0..GYRO);
        for i in 0..3 {
            self.x[IN_EARTH + i] = turned[i];
            for state in 0..IN_EARTH {
                self.covariance.add(IN_EARTH + i, state, carried[i][state]);
            }
            for j in 0..=i {
                let own: f32 = (0..GYRO).fold(0.0, |sum, error| sum + carried[i][error] * gain[j][error]);
                self.covariance.add(
                    IN_EARTH + i,
                    IN_EARTH + j,
                    own + carried[i][IN_EARTH + j] + carried[j][IN_EARTH + i],
                );
            }
        }
        for state in 0..IN_EARTH {
            let walk = if (9..LAG).contains(&state) {
                prior.bias_walk_rad_s_rts * prior.bias_walk_rad_s_rts
            } else {
                let sigma = prior.sigma(state);
                sigma * sigma / prior.forgetting_s
            };
            self.covariance.add(state, state, walk * node.time_s);
        }
        for state in IN_EARTH..STATES {
            self.covariance.add(state, state, walk_ut2);
        }
    }

    pub fn innovation(&self, node: &FieldNode) -> Innovation {
        let mut rows = [[0.0; STATES]; 3];
        let lag_ut_s = node.lag_ut_s - node.spin_rad_s * self.in_body();
        let in_body = node.rotation - node.spin_rad_s * self.x[LAG];
        for (i, row) in rows.iter_mut().enumerate() {
            row[LAG] = lag_ut_s[i];
            for j in 0..3 {
                row[IN_BODY + j] = in_body[(i, j)];
            }
            row[IN_EARTH + i] = 1.0;
        }
        let predicted_ut = self.in_earth() + node.rotation * self.in_body() + lag_ut_s * self.x[LAG];
        let projected = self.covariance.times_within(&rows, LAG..STATES);
        let mut predicted = Matrix3::zeros();
        for (i, carried) in projected.iter().enumerate() {
            for (j, row) in rows.iter().enumerate() {
                predicted[(i, j)] = row.iter().zip(carried).skip(LAG).fold(0.0, |sum, (a, b)| sum + a * b);
            }
        }
        Innovation { innovation_ut: node.field_ut - predicted_ut, projected, predicted }
    }

    /// Updates by a node's innovation, with a noise of variance `noise` on each axis.
    pub fn update(&mut self, innovation: &Innovation, noise: f32) {
        let covariance = innovation.predicted + Matrix3::from_diagonal_element(noise);
        let Some(whitening) = Whitening::new(&covariance) else { return };
        let whitened = whitening.apply(&innovation.innovation_ut);
        // Rows of L^-1 H Sigma: the covariance loses the sum of their squares.
        let mut gains = innovation.projected;
        for state in 0..STATES {
            let column = Vector3::from_fn(|i, _| innovation.projected[i][state]);
            let solved = whitening.apply(&column);
            self.x[state] += solved.dot(&whitened);
            for i in 0..3 {
                gains[i][state] = solved[i];
            }
        }
        self.covariance.add_outers(&gains, -1.0);
    }

    /// Returns true if the states are finite and their variances positive.
    pub fn is_sound(&self) -> bool {
        self.x.iter().all(|x| x.is_finite())
            && (0..STATES).all(|state| {
                let variance = self.covariance.get(state, state);
                variance.is_finite() && variance > 0.0
            })
    }
}
