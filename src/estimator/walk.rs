//! What the globals may change by while the filter runs.

use super::columns::{BIAS, GLOBALS, P};

/// How often they walk, seconds.
pub(super) const EVERY_S: f32 = 10.0;
/// Walk of the bias, rad/s per root second: 3e-3 deg/s. A tighter one is overconfident by 17 % on real recordings.
const BIAS_RAD_S_RTS: f32 = 5.2e-5;
/// Walk of each element of P, per root second: 1e-4 to 3e-4 cost nothing.
const P_RTS: f32 = 2e-4;

/// Variance that a global gains in a second, in squared units of its width.
pub(super) fn variance_per_s(column: usize, sigma: f32) -> f32 {
    let walk = if column >= P.from && column < GLOBALS {
        P_RTS
    } else if BIAS.columns().contains(&column) {
        BIAS_RAD_S_RTS
    } else {
        return 0.0;
    };
    if sigma > 0.0 { walk * walk / (sigma * sigma) } else { 0.0 }
}
