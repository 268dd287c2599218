//! Rows of the rotation.

use super::{Block, NEW, OLD};
use crate::estimator::{
    columns::{ATTITUDE, BIAS},
    preintegration::ByGyro,
    real::{M3, Real},
};

/// Writes the rows of the rotation: new attitude error = old error + turn by the errors of bias and P, in the earth
/// frame.
pub(in crate::estimator) fn rotation<T: Real>(mut block: Block<T>, attitude: &M3<T>, by_gyro: &ByGyro<T>) {
    block.unit(OLD + ATTITUDE, -T::ONE);
    block.unit(NEW + ATTITUDE, T::ONE);
    for (k, by) in by_gyro.iter().enumerate() {
        block.global(BIAS.from + k, &-(attitude * by));
    }
}
