//! Constant rates, an hour of turning, and marks.

use super::*;
use crate::rotation::matrix;

const DT_S: f32 = 0.005;

fn level() -> Propagation {
    Propagation { q: IDENTITY, ..Propagation::new() }
}

#[test]
fn an_hour_of_turning_conserves_the_norm() {
    let mut p = level();
    for i in 0..720_000_u32 {
        let phase = f32::from(u16::try_from(i % 1_000).unwrap_or(0)) * 0.002 - 1.0;
        p.step(DT_S, &Vector3::new(20.0 * phase, 8.0, -30.0 * phase * phase));
    }
    assert!((p.q.norm_squared() - 1.0).abs() < 1e-6);
}

#[test]
fn another_attitude_at_the_mark_is_another_one_now() {
    let step = |p: &mut Propagation, k: u8| {
        let k = f32::from(k);
        p.step(DT_S, &Vector3::new(3.0 - 0.1 * k, 0.07 * k, -2.0));
        if k % 7.0 == 3.0 {
            p.correct(&Vector3::new(0.02, -0.01 * k / 30.0, 0.03));
        }
    };
    let mut p = level();
    (0..30).for_each(|k| step(&mut p, k));
    p.mark();
    let other = exp_quaternion(&Vector3::new(0.4, -0.9, 1.3));
    // Expected attitude: the same increments from the other one at the mark, without the corrections.
    let mut expected = other;
    for k in 30..90 {
        let before = p.q;
        let mut alone = Propagation { q: before, ..Propagation::new() };
        (alone.increment_rad, alone.moving) = (p.increment_rad, p.moving);
        alone.step(DT_S, &Vector3::new(3.0 - 0.1 * f32::from(k), 0.07 * f32::from(k), -2.0));
        expected = renormalised(&(expected * (before.conjugate() * alone.q)));
        step(&mut p, k);
    }
    let by = p.since_mark(&other).unwrap();
    p.turn(&by);
    assert!((matrix(&p.q) - matrix(&expected)).norm() < 1e-5, "{} {}", p.q, expected);
    // The mark is taken once, and never across a gap.
    assert!(p.since_mark(&other).is_none());
    p.mark();
    p.interrupt();
    assert!(p.since_mark(&other).is_none());
}

#[test]
fn a_constant_rate_returns_after_whole_turns() {
    let mut p = level();
    let rate = Vector3::new(0.6, 0.0, 0.8) * core::f32::consts::TAU;
    for _ in 0..2_000 {
        p.step(DT_S, &rate);
    }
    assert!((matrix(&p.q) - nalgebra::Matrix3::identity()).norm() < 2e-4, "{}", matrix(&p.q));
}

/// Drift of classical coning, rad/s: the body z axis draws a cone, and the true attitude is known in
/// closed form.
fn coning_drift_rad_s() -> f64 {
    let (half_angle, omega, dt) = (0.1_f64, 40.0, f64::from(DT_S));
    let truth = |t: f64| {
        let (c, s) = (libm::cos(half_angle / 2.0), libm::sin(half_angle / 2.0));
        [c, s * libm::cos(omega * t), s * libm::sin(omega * t), 0.0]
    };
    // body rate of that attitude (Savage): x -w sin(a) sin(wt), y w sin(a) cos(wt), z -2 w sin^2(a/2)
    let rate_at = |t: f64| {
        let s = libm::sin(half_angle);
        let z = -2.0 * omega * libm::sin(half_angle / 2.0) * libm::sin(half_angle / 2.0);
        [-omega * s * libm::sin(omega * t), omega * s * libm::cos(omega * t), z]
    };
    let mean = |t: f64| {
        let mut sum = [0.0; 3];
        for j in 0..20 {
            let r = rate_at(t - dt + (f64::from(j) + 0.5) * dt / 20.0);
            for k in 0..3 {
                sum[k] += r[k] / 20.0;
            }
        }
        sum
    };
    let mut p = Propagation::new();
    let q0 = truth(0.0);
    p.q = Quaternion::new(q0[0] as f32, q0[1] as f32, q0[2] as f32, q0[3] as f32);
    let steps = 2_000_u16;
    for i in 1..=steps {
        let t = f64::from(i) * dt;
        let w = mean(t);
        p.step(DT_S, &Vector3::new(w[0] as f32, w[1] as f32, w[2] as f32));
    }
    let end = f64::from(steps) * dt;
    let q1 = truth(end);
    let error = p.q * Quaternion::new(q1[0] as f32, q1[1] as f32, q1[2] as f32, q1[3] as f32).conjugate();
    2.0 * f64::from(error.imag().norm()) / end
}

#[test]
fn coning_drift_is_taken_out() {
    // (w / 2) sin^2(a) (1 - sinc(w dt)) for mean rates, 1.33e-3 rad/s here, without the coning term
    let uncorrected = 20.0 * libm::sin(0.1) * libm::sin(0.1) * (1.0 - libm::sin(0.2) / 0.2);
    assert!(coning_drift_rad_s() < 0.02 * uncorrected, "{}", coning_drift_rad_s());
}
