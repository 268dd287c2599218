//! Rows of the declared field of the earth.

use super::{Block, OLD};
use crate::estimator::{
    columns::{FIELD, GLOBALS, HARD_IRON, MAG_MATRIX},
    parameters::mag_columns,
    real::{M3, Real, V3, norm},
};

/// Columns of the magnetometer's matrix and hard iron: the table's first.
const OF_MAGNETOMETER: usize = MAG_MATRIX.count + HARD_IRON.count;

/// Deviations beyond which the field that is read, with its own errors and the declared one's, is not the declared one:
/// by chance once in a million readings.
pub(in crate::estimator) const ANOTHER_FIELD: f32 = 5.0;

/// The earth's field as a survey's reference has it, in units of the estimator's field.
#[derive(Clone, Copy)]
pub(in crate::estimator) struct Declared<T> {
    /// Norm and its deviation, which includes the magnetometer's scale.
    pub norm: [T; 2],
    /// Sine of the dip below the horizontal, and its deviation.
    pub dip_sine: [T; 2],
}

/// Equations of the magnetometer's errors by the declared norm and dip, were the field the one that it reads: rows over
/// the table's first columns, in units of the prior's widths, and their constants at errors of zero.
#[derive(Clone, Copy)]
pub(in crate::estimator) struct ReferenceRows<T> {
    pub by: [[T; OF_MAGNETOMETER]; 2],
    pub constants: [T; 2],
}

/// Rows of a field, earth frame, that is read at this attitude and corrected by the errors `x`. `weight`: root of the
/// share of the declared field's information that counts.
pub(in crate::estimator) fn reference_rows<T: Real>(
    field: &V3<T>,
    attitude: &M3<T>,
    declared: &Declared<T>,
    (weight, x, sigma): (T, &[T; GLOBALS], &[T; GLOBALS]),
) -> ReferenceRows<T> {
    let body = attitude.transpose() * field;
    let row = |slope: V3<T>| {
        let slope = attitude.transpose() * slope * weight;
        let element = |k: usize| at(&slope, k / 3) * at(&body, k % 3);
        let matrix = mag_columns(&core::array::from_fn(element));
        let mut row = [T::ZERO; OF_MAGNETOMETER];
        for ((slot, by), sigma) in row.iter_mut().zip(matrix.iter().chain(slope.iter())).zip(sigma) {
            *slot = *by * *sigma;
        }
        row
    };
    let by = slopes(field, declared).map(row);
    let mut constants = misfits(field, declared).map(|misfit| misfit * weight);
    for (constant, by) in constants.iter_mut().zip(&by) {
        *constant = by.iter().zip(x).fold(*constant, |sum, (by, x)| sum - *by * *x);
    }
    ReferenceRows { by, constants }
}

fn at<T: Real>(vector: &V3<T>, axis: usize) -> T {
    vector.get(axis).copied().unwrap_or(T::ZERO)
}

/// Norm and dip less the declared ones, over their deviations.
fn misfits<T: Real>(field: &V3<T>, declared: &Declared<T>) -> [T; 2] {
    [(norm(field), declared.norm), (dip_sine(field), declared.dip_sine)]
        .map(|(value, [expected, deviation])| (value - expected) / deviation)
}

/// Slopes by the field, earth frame, of norm and dip over their deviations.
fn slopes<T: Real>(field: &V3<T>, declared: &Declared<T>) -> [V3<T>; 2] {
    let length = norm(field);
    let along = field / length;
    let down = (along * along.z - V3::z()) / length;
    [along / declared.norm[1], down / declared.dip_sine[1]]
}

/// Writes the rows that the node's field has the declared norm and the declared dip.
pub(in crate::estimator) fn reference<T: Real>(mut block: Block<T>, field: &V3<T>, declared: &Declared<T>) {
    let [of_norm, of_dip] = slopes(field, declared);
    let zero = V3::new(T::ZERO, T::ZERO, T::ZERO);
    block.states(OLD + FIELD, &nalgebra::Matrix3::from_rows(&[of_norm, of_dip, zero].map(|row| row.transpose())));
    let [norm, dip] = misfits(field, declared);
    block.constant(&V3::new(norm, dip, T::ZERO));
}

/// Sine of the dip of a field.
pub(in crate::estimator) fn dip_sine<T: Real>(field: &V3<T>) -> T {
    -field.z / norm(field)
}

#[cfg(test)]
mod tests;
