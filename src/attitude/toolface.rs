//! Tool angles of an attitude, with their deviations: inclination, azimuth, gravity and magnetic toolface (frames and
//! signs: docs/architecture.md).

use core::f32::consts::{PI, TAU};
use nalgebra::Matrix3;

/// Squared sine of the inclination above which azimuth plus toolface replaces their joint formula: the two agree to
/// 2e-6 rad at 6 deg.
const ADDED_SQUARED_SINE: f32 = 0.01;

/// Steering angles of one attitude: `C = Rz(azimuth) Ry(inclination) Rz(toolface)`, earth NED, tool z
/// down-hole and x at the highside when the toolface is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolAngles {
    /// Angle of the tool axis from the vertical, 0 to pi.
    pub(crate) inclination_rad: f32,
    /// Direction of the tool axis from north, 0 to 2 pi; 0 exactly along the vertical.
    pub(crate) azimuth_rad: f32,
    /// Angle from the highside to x, clockwise looking down-hole, 0 to 2 pi; 0 exactly along the vertical.
    pub(crate) gravity_toolface_rad: f32,
    /// Azimuth plus gravity toolface, 0 to 2 pi: exact down to the vertical, undefined (0) straight up.
    pub(crate) magnetic_toolface_rad: f32,
}

impl ToolAngles {
    /// Computes the angles of a tool-to-NED matrix. Its last row is gravity's direction G in tool axes, its
    /// last column the tool axis in NED: inclination = atan2(hypot(Gx, Gy), Gz), gravity toolface = atan2(Gy,
    /// -Gx), azimuth = atan2(C12, C02), magnetic toolface = atan2(C10 - C01, C00 + C11).
    pub(crate) fn of(c: &Matrix3<f32>) -> Self {
        let (gx, gy, gz) = (c.m31, c.m32, c.m33);
        let squared_sine = gx * gx + gy * gy;
        let azimuth_rad = positive_angle(libm::atan2f(c.m23, c.m13));
        // `0.0 - gx` keeps a zero positive, so that straight down reads 0.
        let gravity_toolface_rad = positive_angle(libm::atan2f(gy, 0.0 - gx));
        let magnetic_toolface_rad = if squared_sine > ADDED_SQUARED_SINE {
            positive_angle(azimuth_rad + gravity_toolface_rad - TAU)
        } else {
            positive_angle(libm::atan2f(c.m21 - c.m12, c.m11 + c.m22))
        };
        Self {
            inclination_rad: libm::atan2f(libm::sqrtf(squared_sine), gz),
            azimuth_rad,
            gravity_toolface_rad,
            magnetic_toolface_rad,
        }
    }
}

/// Standard deviations of the angles, radians; pi stands for an unknown angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToolAngleSigmas {
    pub(crate) inclination_rad: f32,
    pub(crate) azimuth_rad: f32,
    pub(crate) gravity_toolface_rad: f32,
    pub(crate) magnetic_toolface_rad: f32,
}

impl ToolAngleSigmas {
    /// All zero, for a static.
    pub(crate) const UNSET: Self =
        Self { inclination_rad: 0.0, azimuth_rad: 0.0, gravity_toolface_rad: 0.0, magnetic_toolface_rad: 0.0 };

    /// Propagates the covariance (rad^2) of the attitude error phi in NED, `C_true = exp(phi) C`.
    ///
    /// With h = (cos A, sin A, 0) along the azimuth, n = (-sin A, cos A, 0) across it and the tool axis t,
    /// phi = dA z + dI n + dT t. So dI = phi.n, dT = phi.h / sin I, dA = phi_z - dT cos I, and d(A + T) =
    /// phi_z + tan(I/2) phi.h.
    pub(crate) fn of(c: &Matrix3<f32>, covariance: &Matrix3<f32>) -> Self {
        let (t, p) = (c.column(2), covariance);
        let sine = libm::sqrtf(t.x * t.x + t.y * t.y);
        // Along the vertical every direction can be the azimuth's; take north.
        let (hx, hy) = if sine > 1e-6 { (t.x / sine, t.y / sine) } else { (1.0, 0.0) };
        let safe_sine = if sine > 1e-6 { sine } else { 1e-6 };
        let cosine_plus_one = if t.z > -1.0 + 1e-6 { 1.0 + t.z } else { 1e-6 };
        // Variances of phi.n and phi.h, and the covariance of phi.h with phi_z.
        let (xx, xy, yy) = (hx * hx, 2.0 * hx * hy, hy * hy);
        let across = xx * p.m22 - xy * p.m12 + yy * p.m11;
        let along = xx * p.m11 + xy * p.m12 + yy * p.m22;
        let common = hx * p.m13 + hy * p.m23;
        let turned = |by: f32| p.m33 + by * (2.0 * common + by * along);
        let sigma = |variance: f32| {
            if variance < PI * PI { libm::sqrtf(if variance > 0.0 { variance } else { 0.0 }) } else { PI }
        };
        Self {
            inclination_rad: sigma(across),
            azimuth_rad: sigma(turned(-t.z / safe_sine)),
            gravity_toolface_rad: sigma(along / (safe_sine * safe_sine)),
            magnetic_toolface_rad: sigma(turned(sine / cosine_plus_one)),
        }
    }
}

/// Returns true if the hole counts as near vertical. Hysteresis keeps noise at the limit from toggling the
/// report.
pub(crate) fn near_vertical(before: bool, inclination_rad: f32, limit_rad: f32, hysteresis_rad: f32) -> bool {
    inclination_rad < if before { limit_rad + hysteresis_rad } else { limit_rad }
}

/// Wraps an angle of -2 pi to 2 pi into 0 (included) to 2 pi (excluded).
pub(crate) fn positive_angle(angle_rad: f32) -> f32 {
    let turned = if angle_rad < 0.0 { angle_rad + TAU } else { angle_rad };
    // A tiny negative angle rounds to a whole turn.
    if turned < TAU { turned } else { 0.0 }
}

#[cfg(test)]
mod tests {
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
            ToolAngles {
                inclination_rad: 0.0,
                azimuth_rad: 0.0,
                gravity_toolface_rad: 0.0,
                magnetic_toolface_rad: 0.0
            }
        );
        let up = ToolAngles::of(&to_f32(tool_to_ned(0.0, core::f64::consts::PI, 0.0)));
        assert!((up.inclination_rad - PI).abs() < 1e-6);
        let level = ToolAngles::of(&to_f32(tool_to_ned(1.0, core::f64::consts::FRAC_PI_2, 2.0)));
        assert!((level.inclination_rad - PI / 2.0).abs() < 1e-6);
        for c in [Matrix3::identity(), to_f32(tool_to_ned(0.0, core::f64::consts::PI, 0.0))] {
            let s = ToolAngleSigmas::of(&c, &(Matrix3::identity() * 1e-4));
            assert!((s.inclination_rad - 0.01).abs() < 1e-6);
            assert!(
                s.azimuth_rad.is_finite() && s.gravity_toolface_rad.is_finite() && s.magnetic_toolface_rad.is_finite()
            );
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
}
