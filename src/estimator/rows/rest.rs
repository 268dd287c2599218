//! Rows of a rest.

use super::Block;
use crate::estimator::{
    columns::BIAS,
    real::{Real, V3},
};

/// Rows of a rest: the gyro reads its bias. `excess` is the mean raw rate less the present bias.
pub(in crate::estimator) fn rest<T: Real>(mut block: Block<T>, excess: &V3<T>) {
    for (column, axis) in BIAS.columns().zip([V3::x(), V3::y(), V3::z()]) {
        block.global(column, &-axis);
    }
    block.constant(excess);
}
