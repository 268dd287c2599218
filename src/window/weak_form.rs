#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

mod test_function;
mod test_window;

use super::{Increment, TestEquations, rows::GYRO};
use crate::rotation::{exp_quaternion, matrix, middle_to_middle, renormalised};
use nalgebra::{Matrix3, Quaternion, Vector3};
pub(crate) use test_function::TestFunction;
use test_window::{Field, Gravity, TestWindow};

/// Test windows under way at a time: each begins a quarter of its length after the one before it, as sin^2 windows want it
/// (equations half a length apart lose a third of what the samples hold).
pub(crate) const UNDER_WAY: usize = 4;

/// Streaming weak form of the vectors' kinematics.
///
/// u(t) = R0(t) v(t), with the nominal gyro's rotation R0 and a vector v fixed in the earth, obeys u' = -R0 (dw x v) exactly,
/// dw being the true minus the nominal rate: dw = dP w_raw - dc. Multiplied by phi(t) = sin^2 over 2 s (zero at both ends) and
/// integrated by parts, -int phi' u dt = int phi R0 [v]x (dP w_raw - dc) dt: linear in the unknowns for any size of error. A lag
/// tau of the magnetometer adds tau (w x v) to the measured field and a hard iron a constant, so both are linear as well:
/// columns -int phi' R0 (w x v) dt and -int phi' R0 dt. A test window begins every half second.
pub(crate) struct WeakForm {
    /// The nominal model: P row-major, c.
    theta: [f32; GYRO],
    p: Matrix3<f32>,
    c: Vector3<f32>,
    attitude: Quaternion<f32>,
    /// The last good raw rate, held through increments that have none.
    raw: Vector3<f32>,
    /// Of the last two increments.
    rates: [Vector3<f32>; 2],
    /// The de-rotated field of the last two increments.
    previous_fields: [Vector3<f32>; 2],
    /// The de-rotated gravity and field of the last increment, where they were read.
    last_vectors: [Option<Vector3<f32>>; 2],
    windows: [TestWindow; UNDER_WAY],
    /// The rate, rms over a test window, under which one holds nothing about P.
    moving_rate_rad_s: f32,
}

impl WeakForm {
    pub const fn zero() -> Self {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self {
            theta: [0.0; GYRO],
            p: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            c: zero,
            attitude: Quaternion::new(0.0, 0.0, 0.0, 0.0),
            raw: zero,
            rates: [zero; 2],
            previous_fields: [zero; 2],
            last_vectors: [None; 2],
            windows: [TestWindow::zero(); UNDER_WAY],
            moving_rate_rad_s: 0.0,
        }
    }

    /// Begins anew with the nominal model w = P w_raw - c, a test window every `hop` increments.
    pub fn start(&mut self, theta: &[f32; GYRO], hop: usize, moving_rate_rad_s: f32) {
        self.moving_rate_rad_s = moving_rate_rad_s;
        self.theta = *theta;
        self.p = Matrix3::from_fn(|i, j| theta[3 * i + j]);
        self.c = Vector3::new(theta[9], theta[10], theta[11]);
        self.attitude = Quaternion::identity();
        self.raw = Vector3::zeros();
        self.rates = [Vector3::zeros(); 2];
        self.last_vectors = [None; 2];
        self.windows = [TestWindow::zero(); UNDER_WAY];
        for (number, window) in self.windows.iter_mut().enumerate().skip(1) {
            // Each begins later than the one before: it waits at a position before its first.
            window.position = usize::MAX - number * hop + 1;
        }
    }

    /// Takes one increment; returns the equations of the test window that it completes.
    pub fn push(&mut self, increment: &Increment, function: &TestFunction) -> Option<TestEquations> {
        let mut completed = None;
        self.raw = increment.rate.unwrap_or(self.raw);
        let raw = self.raw;
        let rate = self.p * raw - self.c;
        let [earlier, before] = self.rates;
        let turn = middle_to_middle([&earlier, &before, &rate], function.interval_s);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&turn)));
        self.rates = [before, rate];
        let rotation = matrix(&self.attitude);

        // One increment without a reading is bridged: what stands still in the earth is what it was.
        let [last_gravity, last_field] = self.last_vectors;
        let bridged =
            |read: Option<Vector3<f32>>, last: Option<Vector3<f32>>| read.or_else(|| last.map(|u| rotation.tr_mul(&u)));
        self.last_vectors = [increment.gravity, increment.field].map(|read| read.map(|v| rotation * v));
        let gravity = bridged(increment.gravity, last_gravity)
            .map(|v| Gravity { u: rotation * v, gain: rotation * v.cross_matrix() });
        let field = bridged(increment.field, last_field).map(|v| {
            let u = rotation * v;
            let [older, last] = self.previous_fields;
            self.previous_fields = [last, u];
            Field {
                u,
                gain: rotation * v.cross_matrix(),
                lag: rotation * rate.cross(&v),
                roughness: (u - last * 2.0 + older).norm_squared(),
            }
        });
        for window in &mut self.windows {
            let Some(test) = function.at(window.position) else {
                // Waiting for its first increment.
                window.position = window.position.wrapping_add(1);
                continue;
            };
            window.add_rate(increment.rate.as_ref(), &rate);
            window.add_gravity(gravity.as_ref(), &raw, test);
            window.add_field(field.as_ref(), &rotation, &raw, test);
            window.position += 1;
            if window.position == function.length {
                completed = Some(window.complete(self.moving_rate_rad_s, &self.theta));
            }
        }
        completed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        rotation::rotate_back,
        window::{Equations, Grid, MAGNETIC},
    };

    const IDENTITY: [f32; GYRO] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

    /// The field equations about the identity of 50 s of a body that tumbles smoothly, without noise, solved.
    fn solved(p: Matrix3<f32>, bias: Vector3<f32>, lag: f32, iron: Vector3<f32>) -> [f32; MAGNETIC] {
        let grid = Grid::new(20_000);
        let mut weak = WeakForm::zero();
        let mut function = TestFunction::zero();
        function.configure(grid);
        weak.start(&IDENTITY, function.hop(), 0.05);
        let mut sum = Equations::zero();
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
            if let Some(test) = weak.push(&increment, &function) {
                sum.add(&test, &IDENTITY, [1.0; 2]);
            }
        }
        assert!(sum.gravity.rows > 280.0 && sum.magnetic.rows == sum.gravity.rows);
        sum.magnetic.normal.cholesky().unwrap().solve(&sum.magnetic.rhs)
    }

    #[test]
    fn a_gyro_error_of_any_size_is_found_exactly() {
        let p = Matrix3::new(1.12, -0.05, 0.03, 0.04, 0.91, 0.06, -0.02, 0.05, 1.08);
        let bias = Vector3::new(0.03, -0.02, 0.01);
        let x = solved(p, bias, 0.0, Vector3::zeros());
        let c = p * bias;
        for i in 0..3 {
            for j in 0..3 {
                let truth = p[(i, j)] - if i == j { 1.0 } else { 0.0 };
                assert!((x[3 * i + j] - truth).abs() < 1e-3, "P{i}{j} {} {truth}", x[3 * i + j]);
            }
            assert!((x[9 + i] - c[i]).abs() < 1e-3, "c{i} {} {}", x[9 + i], c[i]);
        }
    }

    #[test]
    fn a_lag_and_a_hard_iron_are_told_from_the_gyro() {
        let iron = Vector3::new(3.0, -5.0, 8.0);
        let x = solved(Matrix3::identity(), Vector3::zeros(), 0.008, iron);
        for i in 0..3 {
            assert!((x[13 + i] - iron[i]).abs() < 0.1, "iron {i} {}", x[13 + i]);
        }
        assert!(x[..9].iter().all(|p| p.abs() < 1e-3), "{x:?}");
        // The lag's column is made of the measured field, so the iron (a fifth of the field here) mixes in at second order.
        assert!((x[12] / 0.008 - 1.0).abs() < 0.1, "lag {}", x[12]);
        let x = solved(Matrix3::identity(), Vector3::zeros(), 0.008, Vector3::zeros());
        assert!((x[12] / 0.008 - 1.0).abs() < 0.01, "lag {}", x[12]);
    }
}
