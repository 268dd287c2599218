/// Huber's constant, in sigmas of one component: 95 % efficiency at the normal distribution in one dimension is 1.345; a
/// two-dimensional residual has a norm larger by the ratio of the Rayleigh to the half-normal median, 1.75.
const C: f32 = 1.345 * 1.75;

/// Huber's loss of a squared norm in units of sigma^2: z^2 / 2 near zero, linear in z beyond C.
pub(crate) fn huber(square: f32) -> f32 {
    if square <= C * C { 0.5 * square } else { C * libm::sqrtf(square) - 0.5 * C * C }
}

/// Weight of a residual in the re-weighted normal equations: the loss's derivative in z^2 / 2.
pub(crate) fn huber_weight(square: f32) -> f32 {
    if square <= C * C { 1.0 } else { C / libm::sqrtf(square) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_slope_of_the_loss() {
        for square in [0.1_f32, 1.0, 4.0, 7.0, 100.0, 1e4] {
            let step = 1e-3 * square;
            let slope = (huber(square + step) - huber(square - step)) / step;
            assert!((slope / huber_weight(square) - 1.0).abs() < 1e-2, "{square}");
        }
    }
}
