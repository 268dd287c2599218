//! Rows of the path: velocity and position.

use super::{Block, NEW, OLD, WIDTH, by_axis};
use crate::estimator::{
    columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, ATTITUDE, BIAS, GLOBALS, POSITION, VELOCITY},
    parameters::accel_columns,
    preintegration::{Path, Preintegration},
    real::{M3, Real, cross_matrix},
};

/// Noise of a node's increments of velocity and position: the root of their information, [v 0; pv p] for (velocity,
/// position).
pub(in crate::estimator) struct PathNoise<T> {
    pub velocity: T,
    pub position_by_velocity: T,
    pub position: T,
}

impl<T: Real> PathNoise<T> {
    /// Increments with independent errors of these deviations.
    pub fn independent(velocity_m_s: T, position_m: T) -> Self {
        Self { velocity: T::ONE / velocity_m_s, position_by_velocity: T::ZERO, position: T::ONE / position_m }
    }

    /// White acceleration of density q (m/s per root second): covariance q^2 [T, T^2/2; T^2/2, T^3/3].
    pub fn white(density: T, seconds: T) -> Self {
        // Given the velocity's error e the position's is T e / 2 with variance q^2 T^3 / 12.
        let velocity = T::ONE / (density * seconds.root());
        let position = T::of(12.0).root() * velocity / seconds;
        Self { velocity, position_by_velocity: -position * seconds * T::of(0.5), position }
    }
}

/// Writes the rows that velocity and position go on by the accelerometer's readings and gravity.
pub(in crate::estimator) fn path<T: Real>(
    rows: &mut [[T; WIDTH]; 6],
    sigma: &[T; GLOBALS],
    attitude: &M3<T>,
    pre: &Preintegration<T>,
    noise: &PathNoise<T>,
) {
    let (velocity, position) = rows.split_at_mut(3);
    let link = |rows, path: &Path<T>, state: usize| {
        let mut block = Block { rows, weight: T::ONE, sigma };
        block.states(OLD + ATTITUDE, &cross_matrix(&(attitude * path.value)));
        block.unit(OLD + state, -T::ONE);
        block.unit(NEW + state, T::ONE);
        if state == POSITION {
            block.unit(OLD + VELOCITY, -pre.seconds);
        }
        block.global(ACCEL_LAG.from, &-(attitude * path.by_lag));
        let turned = path.by_matrix.map(|by| -(attitude * by));
        block.globals(ACCEL_MATRIX.from, &by_axis(&turned, accel_columns));
        let by_bias = attitude * path.by_bias;
        for (column, by) in ACCEL_BIAS.columns().zip(by_bias.column_iter()) {
            block.global(column, &-by);
        }
        for (k, by) in path.by_gyro.iter().enumerate() {
            block.global(BIAS.from + k, &-(attitude * by));
        }
    };
    link(velocity, &pre.velocity, VELOCITY);
    link(position, &pre.position, POSITION);
    for (v, p) in velocity.iter_mut().zip(position) {
        for (v, p) in v.iter_mut().zip(p) {
            *p = *p * noise.position + *v * noise.position_by_velocity;
            *v *= noise.velocity;
        }
    }
}
