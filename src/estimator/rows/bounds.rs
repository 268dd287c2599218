//! Rows of the bounds: a probe that is held goes neither far nor fast.

use super::{Block, NEW};
use crate::estimator::real::{Real, V3};

/// Writes the rows that the probe does not go far or fast: velocity or position, from the column `state` on and of the
/// value `now`, is zero but for the noise.
pub(in crate::estimator) fn bounds<T: Real>(mut block: Block<T>, state: usize, now: &V3<T>) {
    block.unit(NEW + state, T::ONE);
    block.constant(now);
}
