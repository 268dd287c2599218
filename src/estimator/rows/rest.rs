use super::Block;
use crate::estimator::{
    columns::BIAS,
    real::{Real, V3},
};

/// What the gyro reads at rest is its bias; `excess`: mean raw rate less the present bias.
pub(in crate::estimator) fn rest<T: Real>(mut block: Block<T>, excess: &V3<T>) {
    for (k, column) in BIAS.columns().enumerate() {
        let mut axis = V3::zeros();
        axis[k] = -T::ONE;
        block.global(column, &axis);
    }
    block.constant(excess);
}
