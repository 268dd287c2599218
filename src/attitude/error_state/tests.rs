//! The scalar updates agree with the textbook's matrix form.

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
        e.reset(state, variance);
    }
    e
}

fn noise() -> ProcessNoise {
    ProcessNoise { attitude: Matrix3::from_diagonal(&Vector3::new(1e-5, 2e-5, 3e-5)), bias: 1e-9, velocity: 1e-5 }
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
        e.predict(&c, 0.196, &noise());
    }
    assert!((dense(&e) - expected).norm() < 1e-5 * expected.norm());
}

#[test]
fn an_optimal_and_a_restricted_gain_agree_with_the_dense_joseph_form() {
    for gain in [Gain::Every, Gain::Heading([true; 3]), Gain::Heading([false, false, true]), Gain::Heading([false; 3])]
    {
        let mut e = started();
        for _ in 0..20 {
            e.predict(&(exp_matrix(&Vector3::new(0.5, 0.2, 0.1)) * 0.02), 0.196, &noise());
        }
        let p = dense(&e);
        let slope = Vector2::new(-1.5, 0.7);
        let mut h = SMatrix::<f64, 1, STATES>::zeros();
        (h[0], h[1], h[HEADING]) = (slope.x.into(), slope.y.into(), 1.0);
        let variance = 0.3_f32;
        let seen = (h * p * h.transpose())[0];
        assert!((f64::from(e.seen_heading_variance(&slope)) - seen).abs() < 1e-5 * seen);
        let mut k = p * h.transpose() / (seen + f64::from(variance));
        let still: &[usize] = match gain {
            Gain::Every => &[],
            Gain::Heading([true, ..]) => &[0, 1, 6, 7],
            Gain::Heading([_, _, true]) => &[0, 1, 3, 4, 6, 7],
            Gain::Heading(_) => &[0, 1, 3, 4, 5, 6, 7],
        };
        still.iter().for_each(|i| k[*i] = 0.0);
        let rest = Dense::identity() - k * h;
        let expected = rest * p * rest.transpose() + k * k.transpose() * f64::from(variance);
        e.update_heading(0.2, &slope, variance, gain);
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
        e.predict(&(exp_matrix(&Vector3::new(0.3, angle, -2.0 * angle)) * 0.02), 0.196, &noise());
        e.update(VELOCITY, 0.0, 7.5, Gain::Every);
        e.update(VELOCITY + 1, 0.0, 7.5, Gain::Every);
        e.update_heading(0.0, &Vector2::new(-2.0, 0.5), 2.0, Gain::Heading([true; 3]));
        if i % 3_000 < 500 {
            (BIAS..VELOCITY).for_each(|k| e.update(k, 0.0, 1e-5, Gain::Every));
        }
    }
    assert!(e.is_sound() && dense(&e).cholesky().is_some());
}
