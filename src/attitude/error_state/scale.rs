//! Errors of the gyro's scale factors and couplings beside the other states: constants in the body frame.

#![allow(clippy::needless_range_loop)] // with iterators it takes twice the instructions

use super::{BIAS, Gain, HEADING, SCALES, STATES, VELOCITY};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Covariance of the errors D, where the true rate is (1 + D) times the compensated one, with the other states and with
/// each other, and the correction collected since it was last taken.
#[derive(Clone, Copy)]
pub(super) struct ScaleErrors {
    /// False while the scale's error is white noise instead.
    is_estimated: bool,
    /// Covariance of these errors with each other state.
    pub(super) cross: [[f32; SCALES]; STATES],
    /// Covariance of these errors with each other, both triangles.
    pub(super) own: [[f32; SCALES]; SCALES],
    correction: [f32; SCALES],
}

impl ScaleErrors {
    /// No errors, which are not estimated.
    pub(super) const NONE: Self = Self {
        is_estimated: false,
        cross: [[0.0; SCALES]; STATES],
        own: [[0.0; SCALES]; SCALES],
        correction: [0.0; SCALES],
    };

    /// Errors with these deviations, uncorrelated with all else.
    pub(super) fn new(deviations: &[f32; SCALES]) -> Self {
        let mut errors = Self { is_estimated: true, ..Self::NONE };
        for k in 0..SCALES {
            errors.own[k][k] = deviations[k] * deviations[k];
        }
        errors
    }

    pub(super) const fn is_estimated(&self) -> bool {
        self.is_estimated
    }

    /// Zeroes the covariance of one of the other states with the errors.
    pub(super) fn forget(&mut self, state: usize) {
        if let Some(cross) = self.cross.get_mut(state) {
            *cross = [0.0; SCALES];
        }
    }

    /// Covariance of the errors with another state.
    pub(super) fn column(&self, state: usize) -> [f32; SCALES] {
        // The checks keep a panic unreachable.
        self.cross.get(state).copied().unwrap_or([0.0; SCALES])
    }

    /// Covariance of the errors with an observation of the heading's error, to which tilt errors add by `slope`.
    pub(super) fn heading_column(&self, slope: &Vector2<f32>) -> [f32; SCALES] {
        core::array::from_fn(|k| self.cross[HEADING][k] + slope.x * self.cross[0][k] + slope.y * self.cross[1][k])
    }

    /// Covariance of one of the errors with the other states, and with all errors.
    pub(super) fn own_column(&self, element: usize) -> ([f32; STATES], [f32; SCALES]) {
        let of_element = |row: &[f32; SCALES]| row.get(element).copied().unwrap_or(0.0);
        (
            core::array::from_fn(|state| of_element(&self.cross[state])),
            self.own.get(element).copied().unwrap_or([0.0; SCALES]),
        )
    }

    /// Variance of one of the errors.
    pub(super) fn variance(&self, element: usize) -> f32 {
        let (_, own) = self.own_column(element);
        own.get(element).copied().unwrap_or(0.0)
    }

    /// Correction collected for one of the errors.
    pub(super) fn correction(&self, element: usize) -> f32 {
        self.correction.get(element).copied().unwrap_or(0.0)
    }

    /// Predicts over a step whose other states have been predicted: phi' = C D w, and the velocity that follows from
    /// this. Each error walks by the variance `walk`.
    pub(super) fn predict(
        &mut self,
        covariance: &mut [[f32; STATES]; STATES],
        rotation_time: &Matrix3<f32>,
        gravity_time: f32,
        rate: &Vector3<f32>,
        walk: f32,
    ) {
        let g = gravity_time;
        // Covariance of the attitude's turn with a state, from the state's row of covariances with the errors.
        let turned = |row: &[f32; SCALES]| {
            let by = |k: usize| row[3 * k] * rate.x + row[3 * k + 1] * rate.y + row[3 * k + 2] * rate.z;
            rotation_time * Vector3::new(by(0), by(1), by(2))
        };
        for k in 0..SCALES {
            for axis in 0..BIAS {
                self.cross[axis][k] -= rotation_time[(axis, 0)] * self.cross[BIAS][k]
                    + rotation_time[(axis, 1)] * self.cross[BIAS + 1][k]
                    + rotation_time[(axis, 2)] * self.cross[BIAS + 2][k];
            }
            self.cross[VELOCITY][k] -= g * self.cross[1][k];
            self.cross[VELOCITY + 1][k] += g * self.cross[0][k];
        }
        let before: [Vector3<f32>; STATES] = core::array::from_fn(|state| turned(&self.cross[state]));
        for k in 0..SCALES {
            let turn = turned(&self.own[k]);
            for axis in 0..BIAS {
                self.cross[axis][k] += turn[axis];
            }
            self.cross[VELOCITY][k] -= g * turn.y;
            self.cross[VELOCITY + 1][k] += g * turn.x;
        }
        for k in 0..SCALES {
            self.own[k][k] += walk;
        }
        // Part that the turn adds to a state's error.
        let added = |turn: &Vector3<f32>, state: usize| match state {
            0..BIAS => turn[state],
            BIAS..VELOCITY => 0.0,
            VELOCITY => -g * turn.y,
            _ => g * turn.x,
        };
        for r in 0..STATES {
            let after = turned(&self.cross[r]);
            for c in r..STATES {
                covariance[r][c] += added(&before[c], r) + added(&after, c);
            }
        }
    }

    /// Updates the scale's errors in a scalar update of all states: see `ErrorState::update_scalar`.
    pub(super) fn update(
        &mut self,
        column: &[f32; STATES],
        of_scale: &[f32; SCALES],
        weight: f32,
        residual: f32,
        gain: Gain,
    ) {
        let moves = gain.moves_scale();
        let k = of_scale.map(|element| if moves { element * weight } else { 0.0 });
        for c in 0..SCALES {
            self.correction[c] += k[c] * residual;
        }
        for r in 0..STATES {
            // The covariance is reduced if either of the two states has a gain.
            let (one, other) = if gain.moves(r) { (column[r] * weight, of_scale) } else { (column[r], &k) };
            for c in 0..SCALES {
                self.cross[r][c] -= one * other[c];
            }
        }
        for r in 0..SCALES {
            for c in 0..SCALES {
                self.own[r][c] -= k[r] * of_scale[c];
            }
        }
    }

    /// Takes the collected correction and zeroes it.
    pub(super) fn take_correction(&mut self) -> Matrix3<f32> {
        let x = core::mem::replace(&mut self.correction, [0.0; SCALES]);
        Matrix3::new(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8])
    }

    /// Returns true if every variance is positive and every correction finite, or nothing is estimated.
    pub(super) fn is_sound(&self) -> bool {
        let sum = self.correction.iter().fold(0.0, |sum, x| sum + x);
        !self.is_estimated || sum.is_finite() && (0..SCALES).all(|k| self.own[k][k] > 0.0)
    }
}
