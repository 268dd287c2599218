//! The effects' part of a node's rows.

use super::Candidates;
use crate::estimator::{
    columns::{FIELD, NODE, POSITION, VELOCITY},
    node::Kind,
    preintegration::Preintegration,
    real::{M3, Real, V3},
    rows::{NEW, OLD, WIDTH},
    update::{REST_WEIGHT, SCRATCH},
};

impl<T: Real, const EFFECTS: usize> Candidates<T, EFFECTS> {
    /// Fills in the effects' columns of rows that have been written, with the weights of these rows: a row without
    /// weight stays zero.
    pub fn fill(
        &self,
        further: &mut [[T; EFFECTS]; SCRATCH],
        rows: &[[T; WIDTH]; SCRATCH],
        attitude: &M3<T>,
        pre: &Preintegration<T>,
        kind: Kind,
    ) {
        *further = [[T::ZERO; EFFECTS]; SCRATCH];
        for (row, node) in further.iter_mut().zip(&self.node) {
            *row = *node;
        }
        let (_, new) = rows.split_at(NODE);
        let (_, own) = further.split_at_mut(NODE);
        let (blocks, _) = new.as_chunks::<3>();
        let (own, _) = own.as_chunks_mut::<3>();
        let [rotated, seen, velocity, position, ..] = blocks else { return };
        let [of_rotation, of_field, of_velocity, of_position, _, _, _, of_rest, ..] = own else { return };
        let share = if pre.fields > 0 { T::ONE / T::of(f32::from(pre.fields)) } else { T::ZERO };
        let per_second = if pre.seconds > T::ZERO { T::ONE / pre.seconds } else { T::ZERO };
        let at = |block: &[[T; WIDTH]; 3], from: usize| -> [T; 3] {
            core::array::from_fn(|i| block.get(i).and_then(|row| row.get(from + i)).copied().unwrap_or(T::ZERO))
        };
        let put = |block: &mut [[T; EFFECTS]; 3], column: usize, weights: &[T; 3], by: &V3<T>| {
            for ((row, weight), by) in block.iter_mut().zip(weights).zip(by.iter()) {
                if let Some(slot) = row.get_mut(column) {
                    *slot += *weight * *by;
                }
            }
        };
        let of_turn = at(rotated, NEW);
        // The coefficient is minus the weight.
        let of_mean = at(seen, OLD + FIELD);
        let of_speed = at(velocity, NEW + VELOCITY);
        let of_place = at(position, NEW + POSITION);
        let of_place_by_speed = at(position, NEW + VELOCITY);
        let rests = kind == Kind::Rest;
        for column in 0..self.used() {
            let rotation = attitude * self.rotation[column];
            put(of_rotation, column, &of_turn, &-rotation);
            put(of_field, column, &of_mean, &-(attitude * self.field[column] * share));
            let (v, p) = (attitude * self.velocity[column], attitude * self.position[column]);
            put(of_velocity, column, &of_speed, &-v);
            put(of_position, column, &of_place, &-p);
            put(of_position, column, &of_place_by_speed, &-v);
            if rests {
                put(of_rest, column, &[T::of(REST_WEIGHT); 3], &(self.rotation[column] * per_second));
            }
        }
    }
}
