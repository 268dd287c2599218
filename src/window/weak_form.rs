#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    Grid, Increment,
    block::{Block, GYRO, MAGNETIC},
};
use crate::rotation::{exp_quaternion, matrix, renormalised};
use core::f32::consts::PI;
use nalgebra::{Matrix3, Quaternion, Vector3};

/// Longest test window in increments; a grid interval is at least 19.98 ms.
const CAPACITY: usize = 50;

/// Accumulators of one test window.
#[derive(Clone, Copy, Debug)]
struct TestWindow {
    position: usize,
    gravity_rows: [[f32; GYRO]; 3],
    gravity_rhs: Vector3<f32>,
    field_rows: [[f32; MAGNETIC]; 3],
    field_rhs: Vector3<f32>,
    square_rate: f32,
    spoilt: bool,
    gravity_missing: bool,
    field_missing: bool,
}

impl TestWindow {
    const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            position: 0,
            gravity_rows: [[0.0; GYRO]; 3],
            gravity_rhs: zero,
            field_rows: [[0.0; MAGNETIC]; 3],
            field_rhs: zero,
            square_rate: 0.0,
            spoilt: false,
            gravity_missing: false,
            field_missing: false,
        }
    }
}

impl TestWindow {
    /// Adds the equations to `block` when nothing spoilt them and the tool moved; begins anew.
    fn complete(&mut self, moving_rate_rad_s: f32, block: &mut Block) {
        block.windows += 1;
        block.spoilt += u16::from(self.spoilt);
        let limit = moving_rate_rad_s * moving_rate_rad_s * self.position as f32;
        if !self.spoilt && self.square_rate > limit {
            for i in 0..3 {
                if !self.gravity_missing {
                    block.gravity.add(&self.gravity_rows[i], self.gravity_rhs[i]);
                }
                if !self.field_missing {
                    block.magnetic.add(&self.field_rows[i], self.field_rhs[i]);
                }
            }
        }
        *self = Self::zero();
    }
}

/// Streaming weak form of the vectors' kinematics.
///
/// u(t) = R0(t) v(t), with the nominal gyro's rotation R0 and a vector v fixed in the earth, obeys u' = -R0 (dw x v) exactly,
/// dw being the true minus the nominal rate: dw = dP w_raw - dc. Multiplied by phi(t) = sin^2 over 1 s (zero at both ends) and
/// integrated by parts, -int phi' u dt = int phi R0 [v]x (dP w_raw - dc) dt: linear in the unknowns for any size of error. A lag
/// tau of the magnetometer adds tau (w x v) to the measured field and a hard iron a constant, so both are linear as well:
/// columns -int phi' R0 (w x v) dt and -int phi' R0 dt. Test windows begin every half second.
pub(crate) struct WeakForm {
    p: Matrix3<f32>,
    c: Vector3<f32>,
    attitude: Quaternion<f32>,
    /// The last good raw rate, held through increments that have none.
    raw: Vector3<f32>,
    previous_turn: Vector3<f32>,
    length: usize,
    interval_s: f32,
    weight: [f32; CAPACITY],
    slope: [f32; CAPACITY],
    windows: [TestWindow; 2],
    moving_rate_rad_s: f32,
}

impl WeakForm {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            p: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            c: zero,
            attitude: Quaternion::new(0.0, 0.0, 0.0, 0.0),
            raw: zero,
            previous_turn: zero,
            length: 0,
            interval_s: 0.0,
            weight: [0.0; CAPACITY],
            slope: [0.0; CAPACITY],
            windows: [TestWindow::zero(); 2],
            moving_rate_rad_s: 0.0,
        }
    }

    /// Sets the grid and the rate (rms over a test window) under which a window holds nothing about P.
    pub fn configure(&mut self, grid: Grid, moving_rate_rad_s: f32) {
        self.length = 2 * grid.increments_in(0.5);
        self.interval_s = grid.interval_s();
        self.moving_rate_rad_s = moving_rate_rad_s;
        let duration = self.length as f32 * self.interval_s;
        for (k, (weight, slope)) in self.weight.iter_mut().zip(&mut self.slope).enumerate().take(self.length) {
            let angle = PI * (k as f32 + 0.5) / self.length as f32;
            let (sine, cosine) = libm::sincosf(angle);
            *weight = sine * sine;
            *slope = 2.0 * sine * cosine * PI / duration;
        }
    }

    /// Begins anew (after a gap too) with the nominal model w = P w_raw - c.
    pub fn start(&mut self, p: Matrix3<f32>, c: Vector3<f32>) {
        self.p = p;
        self.c = c;
        self.attitude = Quaternion::identity();
        self.raw = Vector3::zeros();
        self.previous_turn = Vector3::zeros();
        self.windows = [TestWindow::zero(); 2];
        // The second one begins half a window later: it waits at a position before its first.
        self.windows[1].position = usize::MAX - self.length / 2 + 1;
    }

    /// Changes the nominal model between two increments: windows in progress are dropped.
    pub fn change_model(&mut self, p: Matrix3<f32>, c: Vector3<f32>) {
        self.p = p;
        self.c = c;
        for window in &mut self.windows {
            window.spoilt = true;
        }
    }

    /// Increments from the centre of a test window to its last one.
    pub const fn half_length(&self) -> u32 {
        self.length as u32 / 2
    }

    /// Takes one increment; a test window that it completes and that moved adds its equations to `block`.
    pub fn push(&mut self, increment: &Increment, block: &mut Block) {
        self.raw = increment.rate.unwrap_or(self.raw);
        let raw = self.raw;
        let rate = self.p * raw - self.c;
        let turn = rate * (0.5 * self.interval_s);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&(self.previous_turn + turn))));
        self.previous_turn = turn;
        let rotation = matrix(&self.attitude);

        let gravity = increment.gravity.map(|v| (rotation * v, rotation * v.cross_matrix()));
        let field = increment.field.map(|v| (rotation * v, rotation * v.cross_matrix(), rotation * rate.cross(&v)));
        for window in &mut self.windows {
            let (Some(weight), Some(slope)) = (self.weight.get(window.position), self.slope.get(window.position))
            else {
                // Waiting for its first increment.
                window.position = window.position.wrapping_add(1);
                continue;
            };
            let (weight, slope) = (weight * self.interval_s, -slope * self.interval_s);
            window.spoilt |= increment.rate.is_none();
            window.square_rate += rate.norm_squared();
            match &gravity {
                None => window.gravity_missing = true,
                Some((u, gain)) => {
                    window.gravity_rhs += u * slope;
                    for i in 0..3 {
                        add_gyro_row(&mut window.gravity_rows[i], gain, i, &raw, weight);
                    }
                }
            }
            match &field {
                None => window.field_missing = true,
                Some((u, gain, lag)) => {
                    window.field_rhs += u * slope;
                    for i in 0..3 {
                        let row = &mut window.field_rows[i];
                        add_gyro_row(row, gain, i, &raw, weight);
                        row[GYRO] += slope * lag[i];
                        for j in 0..3 {
                            row[GYRO + 1 + j] += slope * rotation[(i, j)];
                        }
                    }
                }
            }
            window.position += 1;
            if window.position == self.length {
                window.complete(self.moving_rate_rad_s, block);
            }
        }
    }
}

/// Adds `weight * gain_row (x) (raw, -1)` to the gyro's part of a row: d(dw)/d(P, c) seen through R0 [v]x.
fn add_gyro_row<const D: usize>(row: &mut [f32; D], gain: &Matrix3<f32>, i: usize, raw: &Vector3<f32>, weight: f32) {
    for j in 0..3 {
        let g = gain[(i, j)] * weight;
        row[3 * j] += g * raw.x;
        row[3 * j + 1] += g * raw.y;
        row[3 * j + 2] += g * raw.z;
        row[9 + j] -= g;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::rotate_back;

    /// The equations of 50 s of a body that tumbles smoothly, without noise, solved; and the block itself.
    fn solved(p: Matrix3<f32>, bias: Vector3<f32>, lag: f32, iron: Vector3<f32>) -> ([f32; MAGNETIC], Block) {
        let grid = Grid::new(20_000);
        let mut weak = WeakForm::zero();
        weak.configure(grid, 0.05);
        weak.start(Matrix3::identity(), Vector3::zeros());
        let mut block = Block::zero();
        let fine = 200;
        let mut q = Quaternion::<f64>::identity();
        let rate_at = |t: f64| {
            let s = |f: f64, a: f64| (2.0 * core::f64::consts::PI * f * t + a).sin();
            Vector3::new(1.2 * s(0.21, 0.3) + 0.3, 1.0 * s(0.17, 1.7) - 0.2, 1.5 * s(0.13, 2.9) + 0.4)
        };
        let inverse = p.try_inverse().unwrap();
        for k in 0..2500 {
            let (mut rate_sum, mut gravity_sum, mut field_sum) = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            for j in 0..fine {
                let t = (k as f64 + (f64::from(j) + 0.5) / f64::from(fine)) * 0.02;
                let rate = rate_at(t);
                let step = nalgebra::UnitQuaternion::from_scaled_axis(rate * (0.02 / f64::from(fine)));
                q = (q * step.into_inner()).normalize();
                let single = q.cast::<f32>();
                let rate = rate.cast::<f32>();
                rate_sum += rate;
                gravity_sum += rotate_back(&single, &Vector3::new(0.0, 0.0, 9.81));
                let field = rotate_back(&single, &Vector3::new(20.0, 0.0, 45.0));
                // v(t - lag) to first order, which is the model.
                field_sum += field + rate.cross(&field) * lag + iron;
            }
            let mean = |v: Vector3<f32>| v / fine as f32;
            let raw = inverse * mean(rate_sum) + bias;
            let increment =
                Increment { rate: Some(raw), gravity: Some(mean(gravity_sum)), field: Some(mean(field_sum)) };
            weak.push(&increment, &mut block);
        }
        assert!(block.gravity.rows > 280 && block.magnetic.rows == block.gravity.rows);
        let x = block.magnetic.normal.cholesky().unwrap().solve(&block.magnetic.rhs);
        (x, block)
    }

    #[test]
    fn every_grid_has_a_whole_test_window() {
        for period in 100..=20_000 {
            let mut weak = WeakForm::zero();
            weak.configure(Grid::new(period), 0.05);
            assert!((2..=CAPACITY).contains(&weak.length), "{period}: {}", weak.length);
        }
    }

    #[test]
    fn a_gyro_error_of_any_size_is_found_exactly() {
        let p = Matrix3::new(1.12, -0.05, 0.03, 0.04, 0.91, 0.06, -0.02, 0.05, 1.08);
        let bias = Vector3::new(0.03, -0.02, 0.01);
        let (x, mut block) = solved(p, bias, 0.0, Vector3::zeros());
        let c = p * bias;
        for i in 0..3 {
            for j in 0..3 {
                let truth = p[(i, j)] - if i == j { 1.0 } else { 0.0 };
                assert!((x[3 * i + j] - truth).abs() < 1e-3, "P{i}{j} {} {truth}", x[3 * i + j]);
            }
            assert!((x[9 + i] - c[i]).abs() < 1e-3, "c{i} {} {}", x[9 + i], c[i]);
        }

        // Moving the origin to the solution leaves nothing to solve.
        let mut shift = [0.0; GYRO];
        shift.copy_from_slice(&x[..GYRO]);
        let before = block.magnetic.misfit(&x);
        let scale = block.magnetic.square;
        block.recentre(&shift);
        let mut rest = [0.0; MAGNETIC];
        rest[GYRO..].copy_from_slice(&x[GYRO..]);
        let after = block.magnetic.misfit(&rest);
        assert!((after - before).abs() < 1e-5 * scale, "{before} {after} of {scale}");
    }

    #[test]
    fn a_lag_and_a_hard_iron_are_told_from_the_gyro() {
        let iron = Vector3::new(3.0, -5.0, 8.0);
        let (x, _) = solved(Matrix3::identity(), Vector3::zeros(), 0.008, iron);
        for i in 0..3 {
            assert!((x[13 + i] - iron[i]).abs() < 0.1, "iron {i} {}", x[13 + i]);
        }
        assert!(x[..9].iter().all(|p| p.abs() < 1e-3), "{x:?}");
        // The lag's column is made of the measured field, so the iron (a fifth of the field here) mixes in at second order.
        assert!((x[12] / 0.008 - 1.0).abs() < 0.1, "lag {}", x[12]);
        let (x, _) = solved(Matrix3::identity(), Vector3::zeros(), 0.008, Vector3::zeros());
        assert!((x[12] / 0.008 - 1.0).abs() < 0.01, "lag {}", x[12]);
    }
}
