//! Random walks of the globals while the filter runs.

use super::{
    columns::{BIAS, P},
    settings::Noise,
};

/// Interval of the walks, seconds.
pub(super) const EVERY_S: f32 = 10.0;
/// Variance that a global gains in a second, in squared units of its prior's width.
pub(super) fn variance_per_s(column: usize, sigma: f32, noise: &Noise) -> f32 {
    let walk = if P.columns().contains(&column) {
        noise.p_walk_rts
    } else if BIAS.columns().contains(&column) {
        noise.bias_walk_rad_s_rts
    } else {
        return 0.0;
    };
    if sigma > 0.0 { walk * walk / (sigma * sigma) } else { 0.0 }
}
