//! Angles and their deviations against the six-axis formulas and finite differences.

use super::*;
use crate::rotation::{exp_matrix, exp_quaternion, matrix};
use nalgebra::Vector3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

fn uniform(rng: &mut Xoshiro128PlusPlus) -> f32 {
    (rng.next_u32() >> 8) as f32 / 16_777_216.0
}

/// Rz(a) Ry(i) Rz(t) in double precision.
fn tool_to_ned(a: f64, i: f64, t: f64) -> [[f64; 3]; 3] {
    let ((sa, ca), (si, ci), (st, ct)) = (libm::sincos(a), libm::sincos(i), libm::sincos(t));
    [
        [ca * ci * ct - sa * st, -ca * ci * st - sa * ct, ca * si],
        [sa * ci * ct + ca * st, -sa * ci * st + ca * ct, sa * si],
        [-si * ct, si * st, ci],
    ]
}

fn to_f32(c: [[f64; 3]; 3]) -> Matrix3<f32> {
    Matrix3::from_fn(|r, k| c[r][k] as f32)
}

fn apart(a: f64, b: f64) -> f64 {
    libm::fabs(libm::remainder(a - b, core::f64::consts::TAU))
}

#[test]
fn angles_agree_with_the_six_axis_formulas_in_all_quadrants() {
    let dip = 70.0_f64.to_radians();
    let field = [libm::cos(dip), 0.0, libm::sin(dip)];
    for inclination_deg in [1, 5, 30, 60, 90, 120, 150, 179] {
        for azimuth_deg in (0..360).step_by(15) {
            for toolface_deg in (0..360).step_by(15) {
                let [i, a, t] = [inclination_deg, azimuth_deg, toolface_deg].map(|d| f64::from(d).to_radians());
                let c = tool_to_ned(a, i, t);
                // Ideal readings: gravity and field in tool axes.
                let g = [c[2][0], c[2][1], c[2][2]];
                let b: [f64; 3] = core::array::from_fn(|k| (0..3).map(|r| c[r][k] * field[r]).sum());
                let inclination = libm::atan2(libm::hypot(g[0], g[1]), g[2]);
                let toolface = libm::atan2(g[1], -g[0]);
                let azimuth = libm::atan2(
                    g[0] * b[1] - g[1] * b[0],
                    b[2] * (g[0] * g[0] + g[1] * g[1]) - g[2] * (g[0] * b[0] + g[1] * b[1]),
                );
                let angles = ToolAngles::of(&to_f32(c));
                // The error of an angle about the vertical grows as the horizontal part shrinks.
                let bound = 2e-7 / libm::sin(i) + 1e-6;
                assert!(apart(angles.inclination_rad.into(), inclination) < 1e-6);
                assert!(apart(angles.azimuth_rad.into(), azimuth) < bound && apart(azimuth, a) < 1e-9);
                assert!(apart(angles.gravity_toolface_rad.into(), toolface) < bound && apart(toolface, t) < 1e-9);
                if inclination_deg < 179 {
                    assert!(apart(angles.magnetic_toolface_rad.into(), a + t) < 1e-5);
                }
            }
        }
    }
}

#[test]
fn straight_down_and_straight_up_are_finite_and_zero_where_singular() {
    let down = ToolAngles::of(&Matrix3::identity());
    assert_eq!(
        down,
        ToolAngles { inclination_rad: 0.0, azimuth_rad: 0.0, gravity_toolface_rad: 0.0, magnetic_toolface_rad: 0.0 }
    );
    let up = ToolAngles::of(&to_f32(tool_to_ned(0.0, core::f64::consts::PI, 0.0)));
    assert!((up.inclination_rad - PI).abs() < 1e-6);
    let level = ToolAngles::of(&to_f32(tool_to_ned(1.0, core::f64::consts::FRAC_PI_2, 2.0)));
    assert!((level.inclination_rad - PI / 2.0).abs() < 1e-6);
    for c in [Matrix3::identity(), to_f32(tool_to_ned(0.0, core::f64::consts::PI, 0.0))] {
        let s = ToolAngleSigmas::of(&c, &(Matrix3::identity() * 1e-4));
        assert!((s.inclination_rad - 0.01).abs() < 1e-6);
        assert!(s.azimuth_rad.is_finite() && s.gravity_toolface_rad.is_finite() && s.magnetic_toolface_rad.is_finite());
    }
}

#[test]
fn azimuth_plus_toolface_is_the_magnetic_toolface_for_random_attitudes() {
    let mut rng = Xoshiro128PlusPlus::seed_from_u64(7);
    for _ in 0..10_000 {
        let [a, t] = [0; 2].map(|_| uniform(&mut rng) * TAU);
        let i = 1e-3 + uniform(&mut rng) * 3.0;
        let q = exp_quaternion(&Vector3::new(0.0, 0.0, a))
            * exp_quaternion(&Vector3::new(0.0, i, 0.0))
            * exp_quaternion(&Vector3::new(0.0, 0.0, t));
        let angles = ToolAngles::of(&matrix(&q));
        let sum = f64::from(angles.azimuth_rad) + f64::from(angles.gravity_toolface_rad);
        let half_tangent = libm::tan(f64::from(i) / 2.0);
        let bound = 1e-5 + 2e-6 / f64::from(i) + 1e-6 * half_tangent * half_tangent;
        assert!(apart(angles.magnetic_toolface_rad.into(), sum) < bound, "{i} {angles:?}");
        assert!(apart(angles.magnetic_toolface_rad.into(), f64::from(a) + f64::from(t)) < bound);
    }
}

#[test]
fn sigmas_are_the_finite_differences_of_the_angles() {
    let step = 2e-3_f32;
    for (a, i, t) in [(0.3, 0.2, 1.0), (2.5, 1.3, 4.0), (5.9, 2.6, 6.0), (4.0, 0.05, 3.0)] {
        let c = to_f32(tool_to_ned(a, i, t));
        for axis in 0..3 {
            let mut phi = Vector3::zeros();
            phi[axis] = step;
            let plus = ToolAngles::of(&(exp_matrix(&phi) * c));
            let minus = ToolAngles::of(&(exp_matrix(&-phi) * c));
            let mut covariance = Matrix3::zeros();
            covariance[(axis, axis)] = step * step;
            let s = ToolAngleSigmas::of(&c, &covariance);
            for (p, m, sigma) in [
                (plus.inclination_rad, minus.inclination_rad, s.inclination_rad),
                (plus.azimuth_rad, minus.azimuth_rad, s.azimuth_rad),
                (plus.gravity_toolface_rad, minus.gravity_toolface_rad, s.gravity_toolface_rad),
                (plus.magnetic_toolface_rad, minus.magnetic_toolface_rad, s.magnetic_toolface_rad),
            ] {
                let slope = apart(p.into(), m.into()) / 2.0;
                assert!(
                    (slope - f64::from(sigma)).abs() < 2e-3 * f64::from(sigma) + 1e-6,
                    "{a} {i} {axis} {slope} {sigma}"
                );
            }
        }
    }
}

#[test]
fn near_vertical_has_hysteresis() {
    assert!(near_vertical(false, 0.09, 0.1, 0.01) && !near_vertical(false, 0.105, 0.1, 0.01));
    assert!(near_vertical(true, 0.105, 0.1, 0.01) && !near_vertical(true, 0.115, 0.1, 0.01));
}
