#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

use super::{Grid, IncrementRing};
use crate::rotation::{exp_quaternion, matrix, renormalised, rotate_back};
use nalgebra::{Matrix3, Quaternion, Vector3};

/// The rotation from one node to the next, once integrated, with its derivative in the gyro's parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Preintegrated {
    /// Takes a vector in the body frame at the end into the body frame at the beginning.
    pub rotation: Quaternion<f32>,
    /// J (3 x 12), so that R(theta) = R(theta0) Exp(J (theta - theta0)), theta = (P row-major, c), w = P w_raw - c.
    pub jacobian: [[f32; 12]; 3],
    /// Root mean square rate, rad/s.
    pub rate_rms_rad_s: f32,
}

/// Integrates from the middle of increment `from` to the middle of increment `to` with w = P w_raw - c. `None` when a rate in
/// between is suspect.
///
/// A step turns by the mean of two neighbouring increments' rates times the interval, plus the two-sample coning term
/// (phi1 x phi2) / 12 (Bortz's equation to second order for a rate linear in time).
pub(crate) fn preintegrate<const N: usize>(
    ring: &IncrementRing<N>,
    grid: Grid,
    (from, to): (u32, u32),
    (p, c): (&Matrix3<f32>, &Vector3<f32>),
) -> Option<Preintegrated> {
    let dt = grid.interval_s();
    let mut q = Quaternion::identity();
    let mut rotation = Matrix3::identity();
    // Sum over the steps of R (x) (w_raw, -1) dt, in the frame at the beginning; the trapezoid rule halves the ends.
    let mut gain = [[0.0_f32; 4]; 9];
    let mut square = 0.0;
    let mut raw = ring.get(from).rate?;
    let mut rate = p * raw - c;
    accumulate(&mut gain, &rotation, &raw, 0.5 * dt);
    for index in from + 1..=to {
        let next_raw = ring.get(index).rate?;
        let next_rate = p * next_raw - c;
        let turn = (rate + next_rate) * (0.5 * dt) + rate.cross(&next_rate) * (dt * dt / 12.0);
        q = renormalised(&(q * exp_quaternion(&turn)));
        rotation = matrix(&q);
        (raw, rate) = (next_raw, next_rate);
        square += rate.norm_squared();
        accumulate(&mut gain, &rotation, &raw, if index == to { 0.5 * dt } else { dt });
    }
    let mut jacobian = [[0.0; 12]; 3];
    for column in 0..3 {
        for k in 0..4 {
            // Column `column` of R (x) entry k, carried into the frame at the end.
            let v = Vector3::new(gain[3 * column][k], gain[3 * column + 1][k], gain[3 * column + 2][k]);
            let end = rotate_back(&q, &v);
            for (row, value) in jacobian.iter_mut().zip(end.iter()) {
                row[if k < 3 { 3 * column + k } else { 9 + column }] = *value;
            }
        }
    }
    let steps = (to - from) as f32;
    Some(Preintegrated { rotation: q, jacobian, rate_rms_rad_s: libm::sqrtf(square / steps) })
}

/// gain[3 column + row][k] += R[row, column] (w_raw, -1)[k] dt.
fn accumulate(gain: &mut [[f32; 4]; 9], rotation: &Matrix3<f32>, raw: &Vector3<f32>, dt: f32) {
    let w = [raw.x * dt, raw.y * dt, raw.z * dt, -dt];
    for (sums, r) in gain.iter_mut().zip(rotation.iter()) {
        for (sum, w) in sums.iter_mut().zip(&w) {
            *sum += r * w;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::{Increment, Scales};

    fn ring() -> IncrementRing<64> {
        let mut ring = IncrementRing::zero();
        ring.start(Scales::new(10.0, 160.0, 1000.0));
        for k in 0..60 {
            let t = k as f32 * 0.02;
            let rate = Vector3::new(libm::sinf(2.0 * t), 1.5 * libm::cosf(3.0 * t), 2.0 + libm::sinf(5.0 * t));
            ring.push(&Increment { rate: Some(rate), gravity: None, field: None });
        }
        ring
    }

    fn model(delta: &[f32; 12]) -> (Matrix3<f32>, Vector3<f32>) {
        let mut p = Matrix3::identity();
        let mut c = Vector3::zeros();
        for i in 0..3 {
            for j in 0..3 {
                p[(i, j)] += delta[3 * i + j];
            }
            c[i] = delta[9 + i];
        }
        (p, c)
    }

    #[test]
    fn the_jacobian_is_the_finite_difference() {
        let (ring, grid) = (ring(), Grid::new(20_000));
        let (p, c) = model(&[0.0; 12]);
        let nominal = preintegrate(&ring, grid, (2, 52), (&p, &c)).unwrap();
        for parameter in 0..12 {
            let mut delta = [0.0; 12];
            delta[parameter] = 2e-3;
            let (p, c) = model(&delta);
            let moved = preintegrate(&ring, grid, (2, 52), (&p, &c)).unwrap();
            let difference = (nominal.rotation.conjugate() * moved.rotation).imag() * 2.0 / 2e-3;
            for axis in 0..3 {
                let j = nominal.jacobian[axis][parameter];
                assert!((j - difference[axis]).abs() < 0.01, "{parameter} {axis}: {j} {}", difference[axis]);
            }
        }
    }

    #[test]
    fn a_suspect_increment_leaves_no_segment() {
        let mut ring = ring();
        ring.push(&Increment { rate: None, gravity: None, field: None });
        assert!(preintegrate(&ring, Grid::new(20_000), (20, 60), (&Matrix3::identity(), &Vector3::zeros())).is_none());
    }
}
