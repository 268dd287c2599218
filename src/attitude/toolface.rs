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
mod tests;
