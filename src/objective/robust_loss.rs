/// Deviations by which a sum of squares of normal variables exceeds its mean once in a thousand.
const ONCE_IN_A_THOUSAND: f32 = 3.09;

/// Sum of `count` squared standard normal variables beyond which a stretch is not believed: the mean and 3.09 deviations of
/// chi-square, sqrt(2 count).
fn limit(count: f32) -> f32 {
    count + ONCE_IN_A_THOUSAND * libm::sqrtf(2.0 * count)
}

/// Whether a stretch is believed. Most are, and that takes no root.
fn is_believed(square: f32, count: f32) -> bool {
    square <= count || square <= limit(count)
}

/// Huber's loss of a stretch's sum of squares: half of it up to the limit, growing with its root beyond.
pub(crate) fn huber(square: f32, count: f32) -> f32 {
    if is_believed(square, count) {
        return 0.5 * square;
    }
    let limit = limit(count);
    libm::sqrtf(limit * square) - 0.5 * limit
}

/// Weight of a stretch in the re-weighted normal equations: the loss's derivative in half the sum.
pub(crate) fn huber_weight(square: f32, count: f32) -> f32 {
    if is_believed(square, count) { 1.0 } else { libm::sqrtf(limit(count) / square) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_slope_of_the_loss() {
        for square in [0.1_f32, 10.0, 60.0, 100.0, 1e4] {
            let step = 1e-2 * square;
            let slope = (huber(square + step, 50.0) - huber(square - step, 50.0)) / step;
            assert!((slope / huber_weight(square, 50.0) - 1.0).abs() < 1e-2, "{square}: {slope}");
        }
    }
}
