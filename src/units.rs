//! Units beside the SI.

/// Standard gravity, m/s^2 (ISO 80000-3).
pub(crate) const STANDARD_GRAVITY_M_S2: f32 = 9.806_65;
/// Degrees in a radian.
pub(crate) const DEGREES: f32 = 180.0 / core::f32::consts::PI;
/// Factor from rad/s per m/s^2 to deg/s per g.
pub(crate) const DEG_S_PER_G: f32 = STANDARD_GRAVITY_M_S2 * 180.0 / core::f32::consts::PI;
