use super::*;
use crate::estimator::columns::{BIAS, GLOBALS, HARD_IRON, MAG_LAG, P};

#[test]
fn what_is_kept_and_the_drift_make_up_the_prior() {
    // Over 10 K: 0.03 %/K, 0.01 %/K and 0.1 mg/K. The lag between accelerometer and gyro is the chip's.
    let drifts = [(MAG_MATRIX, 0.003), (ACCEL_LAG, 0.0), (ACCEL_MATRIX, 0.001), (ACCEL_BIAS, 0.009_81)];
    for (group, drift) in drifts {
        for (column, width) in group.columns().flat_map(|column| [0.012, 0.03, 0.1].map(|width| (column, width))) {
            let drifted = width * libm::sqrtf(1.0 - kept(column, width) * kept(column, width));
            assert!((drifted - drift).abs() < 1e-3 * width, "{} {width}: {drifted}", group.name);
        }
        // A drift as wide as the prior leaves nothing.
        assert!(group.columns().all(|column| kept(column, 0.99 * drift) == 0.0), "{}", group.name);
    }
    for group in [HARD_IRON, MAG_LAG, BIAS, P] {
        assert!(group.columns().all(|column| kept(column, 1.0) == 0.0), "{}", group.name);
    }
    let count: usize = drifts.iter().map(|(group, _)| group.count).sum();
    assert_eq!(count + HARD_IRON.count + MAG_LAG.count + BIAS.count + P.count, GLOBALS);
}
