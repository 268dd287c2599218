//! Rows of a rest.

use super::Block;
use crate::estimator::{
    columns::BIAS,
    real::{Real, V3},
};

/// Deviation of a rest's rate from zero, beyond the gyro's own noise: 0.05 deg/s, the slowest turn that a second of
/// vector readings can rule out.
const REST_RATE_RAD_S: f32 = 8.7e-4;
/// Weight of the rows of a rest.
pub(in crate::estimator) const REST_WEIGHT: f32 = 1.0 / REST_RATE_RAD_S;

/// Rows of a rest: the gyro reads its bias. `excess` is the mean raw rate less the present bias.
pub(in crate::estimator) fn rest<T: Real>(mut block: Block<T>, excess: &V3<T>) {
    for (column, axis) in BIAS.columns().zip([V3::x(), V3::y(), V3::z()]) {
        block.global(column, &-axis);
    }
    block.constant(excess);
}
