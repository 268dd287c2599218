//! Rows of the field.

use super::{Block, NEW, OLD, by_axis};
use crate::estimator::{
    columns::{ATTITUDE, BIAS, FIELD, HARD_IRON, MAG_LAG, MAG_MATRIX},
    parameters::mag_columns,
    preintegration::Preintegration,
    real::{M3, Real, V3, cross_matrix},
};

/// The mean field of a node, turned to its first instant and to the earth frame.
pub(in crate::estimator) struct FieldReading<'a, T> {
    pub attitude: &'a M3<T>,
    pub pre: &'a Preintegration<T>,
    /// One over the number of increments that hold a field.
    pub share: T,
    /// Mean field, earth frame.
    pub mean: V3<T>,
    /// Mean less the earth field of the node.
    pub innovation: V3<T>,
}

/// Writes the rows that the mean field is the earth's.
pub(in crate::estimator) fn field<T: Real>(mut block: Block<T>, reading: &FieldReading<T>) {
    let FieldReading { attitude, pre, share, mean, innovation } = reading;
    block.states(OLD + ATTITUDE, &-cross_matrix(mean));
    block.unit(OLD + FIELD, -T::ONE);
    let to_earth = *attitude * *share;
    let turned = pre.field_by_matrix.map(|by| to_earth * by);
    block.globals(MAG_MATRIX.from, &by_axis(&turned, mag_columns));
    for (column, by) in HARD_IRON.columns().zip(pre.field_by_iron.column_iter()) {
        block.global(column, &(to_earth * by));
    }
    block.global(MAG_LAG.from, &(to_earth * pre.field_by_lag));
    for (k, by) in pre.field_by_gyro.iter().enumerate() {
        block.global(BIAS.from + k, &(to_earth * by));
    }
    block.constant(innovation);
}

/// Writes the rows that the earth field stays as it was, but for a walk.
pub(in crate::estimator) fn field_walk<T: Real>(mut block: Block<T>) {
    block.unit(OLD + FIELD, -T::ONE);
    block.unit(NEW + FIELD, T::ONE);
}
