//! The average beside effects that are taken out.

use super::*;
use crate::estimator::columns::BIAS;

/// Without a rest the bias is averaged over the scales of its prior. That average is over before the effects'
/// uncertainty is added.
#[test]
fn what_is_not_known_of_an_effect_moves_no_mean_whether_or_not_a_rest_has_measured_the_bias() {
    for is_bias_measured in [false, true] {
        let mut averaging = Averaging::<f64>::zero();
        let mut of = Gaussian { mean: [0.0; GYRO], covariance: [0.0; triangle(GYRO)] };
        (0..GYRO).for_each(|i| of.covariance[triangle(i) + i] = if i < NINE { 0.25 } else { 1e-4 });
        of.covariance[triangle(NINE)] = 2e-3;
        of.mean[NINE..].fill(0.1);
        averaging.sum.add(&of, &[1.0], 0.0, [0.0; GROUPS]);
        averaging.finish(is_bias_measured);
        let before = *averaging.result();
        let mut by = [0.0; GLOBALS];
        by[BIAS.from] = 0.2;
        averaging.spread(&by);
        let after = averaging.result();
        assert_eq!(after.mean, before.mean);
        let grown = after.covariance[triangle(NINE) + NINE] - before.covariance[triangle(NINE) + NINE];
        assert!((grown - 0.04).abs() < 1e-12, "{grown}");
    }
}
