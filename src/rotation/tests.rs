//! Rotations against closed forms.

use super::*;

fn exact(v: [f64; 3]) -> [f64; 4] {
    let angle = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let s = if angle > 0.0 { libm::sin(angle / 2.0) / angle } else { 0.5 };
    [libm::cos(angle / 2.0), v[0] * s, v[1] * s, v[2] * s]
}

fn worst_error(from_rad: f32, to_rad: f32) -> f64 {
    let mut worst = 0.0_f64;
    for step in 0..=400_u16 {
        let angle = from_rad + (to_rad - from_rad) * f32::from(step) / 400.0;
        for axis in [[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.36, 0.48, -0.8], [-0.577_350_26; 3]] {
            let v = Vector3::from(axis) * angle;
            let q = exp_quaternion(&v);
            let e = exact([f64::from(v.x), f64::from(v.y), f64::from(v.z)]);
            for (a, b) in [(q.w, e[0]), (q.i, e[1]), (q.j, e[2]), (q.k, e[3])] {
                worst = f64::max(worst, (f64::from(a) - b).abs());
            }
        }
    }
    worst
}

#[test]
fn the_series_keeps_its_documented_bounds() {
    assert!(worst_error(0.0, 1.0) < 3e-7, "{}", worst_error(0.0, 1.0));
    assert!(worst_error(1.0, 2.0 * core::f32::consts::PI) < 3e-6, "{}", worst_error(1.0, 6.3));
}

#[test]
fn sine_and_cosine_keep_their_documented_bounds() {
    for (most, bound) in [(1.0_f32, 1.2e-7), (100.0, 1.5e-7), (10_000.0, 1e-6)] {
        let mut worst = 0.0_f64;
        for step in -50_000_i32..=50_000 {
            let angle = most * step as f32 / 50_000.0;
            let (s, c) = sine_and_cosine(angle);
            let exact = libm::sincos(f64::from(angle));
            worst = worst.max((f64::from(s) - exact.0).abs()).max((f64::from(c) - exact.1).abs());
        }
        assert!(worst < bound, "{worst} up to {most} rad");
    }
    assert_eq!(sine_and_cosine(0.0), (0.0, 1.0));
    assert!(sine_and_cosine(f32::INFINITY).0.is_nan() && sine_and_cosine(f32::NAN).1.is_nan());
}

#[test]
fn the_matrix_turns_a_vector_as_the_quaternion_does() {
    let rotation = Vector3::new(0.3, -0.7, 0.5);
    let q = exp_quaternion(&rotation);
    let v = Vector3::new(1.0, 2.0, -3.0);
    let turned = q * Quaternion::from_imag(v) * q.conjugate();
    assert!((exp_matrix(&rotation) * v - turned.imag()).norm() < 2e-6);
    // right-handed: a quarter turn about z takes x to y
    let quarter = exp_matrix(&Vector3::new(0.0, 0.0, core::f32::consts::FRAC_PI_2));
    assert!((quarter * Vector3::x() - Vector3::y()).norm() < 1e-6);
}

/// Vector `v` rotated by the rotation vector `phi`, in f64, by sine and cosine.
fn turned(phi: &Vector3<f32>, v: &Vector3<f32>) -> Vector3<f64> {
    nalgebra::Rotation3::from_scaled_axis(phi.cast::<f64>()) * v.cast::<f64>()
}

#[test]
fn a_matrix_has_its_quaternion() {
    for axis in [[1.0, 0.0, 0.0], [0.0, -0.6, 0.8], [0.36, 0.48, -0.8], [-0.577_350_26; 3], [0.0, 0.0, 1.0]] {
        for step in 0..=62_u8 {
            let turned = matrix(&exp_quaternion(&(Vector3::from(axis) * (0.1 * f32::from(step)))));
            let q = quaternion(&turned);
            assert!((matrix(&q) - turned).norm() < 2e-6 && (q.norm_squared() - 1.0).abs() < 1e-6, "{turned} {q}");
        }
    }
}

#[test]
fn vectors_are_rotated_within_the_stated_bounds_there_and_back() {
    let v = Vector3::new(0.3, -0.8, 0.52).normalize();
    let axis = Vector3::new(0.6_f32, 0.64, -0.48);
    for (angle, bound) in [(1e-4_f32, 4e-7), (0.01, 4e-7), (0.1, 4e-7), (0.35, 5e-7), (0.5, 2.5e-6)] {
        let phi = axis * angle;
        let q = exp_quaternion(&phi);
        assert!((rotate(&q, &v).cast::<f64>() - turned(&phi, &v)).norm() < bound);
        assert!((rotate_back(&q, &rotate(&q, &v)) - v).norm() < 5e-7);
    }
}

#[test]
fn interval_means_add_up_to_the_angle_turned() {
    // A rate that swings between nearly 0 and twice its mean at 0.25 Hz, as means over 20 ms; its angle
    // is known in closed form.
    let (dt, w) = (0.02_f64, 0.5 * core::f64::consts::PI);
    let angle = |t: f64| 3.2 * t - 3.0 / w * (libm::cos(w * t) - 1.0);
    let mean = |k: i32| ((angle(f64::from(k + 1) * dt) - angle(f64::from(k) * dt)) / dt) as f32 * Vector3::z();
    // Half a period of the rate's swing: over a whole one an error of the swinging part would cancel.
    let turned: f64 =
        (0..100).map(|k| f64::from(middle_to_middle([&mean(k - 1), &mean(k), &mean(k + 1)], dt as f32).z)).sum();
    let exact = angle(100.5 * dt) - angle(0.5 * dt);
    assert!((turned / exact - 1.0).abs() < 2e-6, "{turned} {exact}");
}

#[test]
fn what_is_no_rotation_is_the_identity() {
    for bad in [f32::NAN, f32::INFINITY, 1e30, 1e4] {
        assert_eq!(exp_quaternion(&Vector3::new(bad, 0.0, 0.0)), IDENTITY);
    }
}
