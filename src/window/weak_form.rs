#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

mod quarter;
mod test_function;
mod test_window;

use super::{Increment, TestEquations, motion_sum::MotionSum, rows::GYRO};
use crate::rotation::{exp_quaternion, matrix, middle_to_middle, renormalised, times};
use core::hint::black_box;
use nalgebra::{Matrix3, Quaternion, Vector3};
use quarter::Quarter;
pub(crate) use test_function::TestFunction;

/// Test windows under way at a time: each begins a quarter of its length after the one before it, as sin^2 windows want it
/// (equations half a length apart lose a third of what the samples hold).
pub(crate) const UNDER_WAY: usize = 4;

/// Streaming weak form of the vectors' kinematics.
///
/// u(t) = R0(t) v(t), with the nominal gyro's rotation R0 and a vector v fixed in the earth, obeys u' = -R0 (dw x v) exactly,
/// dw being the true minus the nominal rate: dw = dP w_raw - dc. Multiplied by phi(t) = sin^2 over 2 s (zero at both ends) and
/// integrated by parts, -int phi' u dt = int phi R0 [v]x (dP w_raw - dc) dt: linear in the unknowns for any size of error. A lag
/// tau of the magnetometer adds tau (w x v) to the measured field and a hard iron a constant, so both are linear as well:
/// columns -int phi' R0 (w x v) dt and -int phi' R0 dt. A test window begins every half second, and the four that hold a half second share
/// its sums.
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
    /// Increments whose motion is not in the quarter yet, and the sums of their cosines and sines.
    latest: MotionSum,
    latest_angle: [f32; 2],
    /// Those of the latest test window, in turn.
    quarters: [Quarter; UNDER_WAY],
    /// Increments in the one that is under way, and quarters before it.
    position: usize,
    ended: usize,
    /// The rate, rms over a test window, under which one holds nothing about P.
    moving_rate_rad_s: f32,
    /// Length of a test window, in quarters of the longest.
    length_quarters: usize,
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
            latest: MotionSum::zero(),
            latest_angle: [0.0; 2],
            quarters: [Quarter::zero(); UNDER_WAY],
            position: 0,
            ended: 0,
            moving_rate_rad_s: 0.0,
            length_quarters: 0,
        }
    }

    /// Begins anew with the nominal model w = P w_raw - c and test windows of so many quarters.
    pub fn start(&mut self, theta: &[f32; GYRO], moving_rate_rad_s: f32, length_quarters: usize) {
        self.length_quarters = length_quarters;
        self.moving_rate_rad_s = moving_rate_rad_s;
        self.theta = *theta;
        self.p = Matrix3::from_fn(|i, j| theta[3 * i + j]);
        self.c = Vector3::new(theta[9], theta[10], theta[11]);
        self.attitude = Quaternion::identity();
        self.raw = Vector3::zeros();
        self.rates = [Vector3::zeros(); 2];
        self.last_vectors = [None; 2];
        (self.latest, self.latest_angle) = (MotionSum::zero(), [0.0; 2]);
        (self.position, self.ended) = (0, 0);
    }

    /// Takes one increment; returns the equations of the test window that it completes.
    #[inline(never)]
    pub fn push(&mut self, increment: &Increment, function: &TestFunction) -> Option<TestEquations> {
        // There is one of it in a program, and with its address known each access to a field would compute the field's own from scratch.
        black_box(self).take(increment, function)
    }

    #[inline(always)]
    fn take(&mut self, increment: &Increment, function: &TestFunction) -> Option<TestEquations> {
        self.raw = increment.rate.unwrap_or(self.raw);
        let raw = self.raw;
        let rate = times(&self.p, &raw) - self.c;
        let [earlier, before] = self.rates;
        let turn = middle_to_middle([&earlier, &before, &rate], function.interval_s);
        self.attitude = renormalised(&(self.attitude * exp_quaternion(&turn)));
        self.rates = [before, rate];
        let rotation = matrix(&self.attitude);

        let quarter = &mut self.quarters[self.ended % UNDER_WAY];
        if self.position == 0 {
            *quarter = Quarter::zero();
        }
        quarter.spoilt |= increment.rate.is_none();
        quarter.square_rate += rate.norm_squared();
        let angle = function.angle(self.position);
        self.latest.add(&rotation, &raw);
        for (sum, x) in self.latest_angle.iter_mut().zip(angle) {
            *sum += x;
        }
        for (sensor, read) in [increment.gravity, increment.field].into_iter().enumerate() {
            // One increment without a reading is bridged: what stands still in the earth is what it was.
            let read = read.map(|v| times(&rotation, &v));
            let u = read.or(self.last_vectors[sensor]);
            self.last_vectors[sensor] = read;
            quarter.add_vector(sensor, u.as_ref(), angle);
            if let (Some(u), 1) = (u, sensor) {
                let [older, last] = self.previous_fields;
                quarter.square_roughness += (u - last * 2.0 + older).norm_squared();
                self.previous_fields = [last, u];
            }
        }
        self.position += 1;
        let is_complete = self.position >= function.hop();
        if self.latest.is_full() || is_complete {
            quarter.add_motion(self.latest.factors(), self.latest.mean(self.latest_angle));
            (self.latest, self.latest_angle) = (MotionSum::zero(), [0.0; 2]);
        }
        if !is_complete {
            return None;
        }
        self.position = 0;
        self.ended += 1;
        let all: [&Quarter; UNDER_WAY] =
            core::array::from_fn(|number| &self.quarters[(self.ended + number) % UNDER_WAY]);
        let quarters = all.get(UNDER_WAY - self.length_quarters..).filter(|_| self.ended >= self.length_quarters)?;
        Some(test_window::equations(quarters, function, self.moving_rate_rad_s, &self.theta))
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
    fn solved(quarters: usize, p: Matrix3<f32>, bias: Vector3<f32>, lag: f32, iron: Vector3<f32>) -> [f32; MAGNETIC] {
        let grid = Grid::new(20_000);
        let mut weak = WeakForm::zero();
        let mut function = TestFunction::zero();
        function.configure(grid);
        weak.start(&IDENTITY, 0.05, quarters);
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
        let c = p * bias;
        for quarters in [UNDER_WAY, 2, 1] {
            let x = solved(quarters, p, bias, 0.0, Vector3::zeros());
            for i in 0..3 {
                for j in 0..3 {
                    let truth = p[(i, j)] - if i == j { 1.0 } else { 0.0 };
                    assert!((x[3 * i + j] - truth).abs() < 1e-3, "{quarters}: P{i}{j} {} {truth}", x[3 * i + j]);
                }
                assert!((x[9 + i] - c[i]).abs() < 1e-3, "{quarters}: c{i} {} {}", x[9 + i], c[i]);
            }
        }
    }

    #[test]
    fn a_lag_and_a_hard_iron_are_told_from_the_gyro() {
        let iron = Vector3::new(3.0, -5.0, 8.0);
        let x = solved(UNDER_WAY, Matrix3::identity(), Vector3::zeros(), 0.008, iron);
        for i in 0..3 {
            assert!((x[13 + i] - iron[i]).abs() < 0.1, "iron {i} {}", x[13 + i]);
        }
        assert!(x[..9].iter().all(|p| p.abs() < 1e-3), "{x:?}");
        // The lag's column is made of the measured field, so the iron (a fifth of the field here) mixes in at second order.
        assert!((x[12] / 0.008 - 1.0).abs() < 0.1, "lag {}", x[12]);
        let x = solved(UNDER_WAY, Matrix3::identity(), Vector3::zeros(), 0.008, Vector3::zeros());
        assert!((x[12] / 0.008 - 1.0).abs() < 0.01, "lag {}", x[12]);
    }
}
