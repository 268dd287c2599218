//! Additions of the effects to rotation, field, velocity and position from node to node, and their part of a node's
//! rows.

use super::Place;
use crate::{
    compensation::Sensor,
    estimator::{
        columns::{FIELD, NODE, POSITION, VELOCITY},
        preintegration::{Preintegration, Turned},
        real::{M3, Real, V3, zero3},
        rows::{NEW, OLD, REST_WEIGHT, SCRATCH, WIDTH},
    },
};

/// Sums of each column since the node before, in the node's frame.
pub(super) struct Sums<T, const EFFECTS: usize> {
    rotation: [V3<T>; EFFECTS],
    field: [V3<T>; EFFECTS],
    velocity: [V3<T>; EFFECTS],
    position: [V3<T>; EFFECTS],
}

impl<T: Real, const EFFECTS: usize> Sums<T, EFFECTS> {
    pub const fn zero() -> Self {
        Self {
            rotation: [zero3(); EFFECTS],
            field: [zero3(); EFFECTS],
            velocity: [zero3(); EFFECTS],
            position: [zero3(); EFFECTS],
        }
    }

    /// Begins a node.
    pub fn start_node(&mut self) {
        self.rotation = [zero3(); EFFECTS];
        self.field = [zero3(); EFFECTS];
        self.velocity = [zero3(); EFFECTS];
        self.position = [zero3(); EFFECTS];
    }

    /// Forgets the sums of a column.
    pub fn forget(&mut self, column: usize) {
        let sums = [&mut self.rotation, &mut self.field, &mut self.velocity, &mut self.position];
        sums.into_iter().filter_map(|sum| sum.get_mut(column)).for_each(|sum| *sum = zero3());
    }

    /// Adds the terms of an increment, turned to the node's beginning, to the sums of the node.
    pub fn add(&mut self, turned: &Turned<T>, terms: &[V3<T>; EFFECTS], places: &[Place]) {
        let Turned { middle, seconds, field, force } = turned;
        let (dt, half) = (*seconds, *seconds * T::of(0.5));
        let sums = self.rotation.iter_mut().zip(&mut self.field).zip(&mut self.velocity).zip(&mut self.position);
        let terms = terms.iter().zip(places);
        for ((((rotation, field_sum), velocity), position), (term, Place { sensor, .. })) in sums.zip(terms) {
            // The reading less its effect is the truth, so the term is subtracted.
            let term = -(middle * term);
            let mut go_on = |step: V3<T>| {
                *position += *velocity * dt + step * (dt * half);
                *velocity += step * dt;
            };
            match *sensor {
                Sensor::Gyro => {
                    let at_middle = *rotation + term * half;
                    if let Some(field) = field {
                        *field_sum += at_middle.cross(field);
                    }
                    if let Some(force) = force {
                        go_on(at_middle.cross(force));
                    }
                    *rotation += term * dt;
                }
                Sensor::Accelerometer if force.is_some() => go_on(term),
                Sensor::Magnetometer if field.is_some() => *field_sum += term,
                Sensor::Accelerometer | Sensor::Magnetometer => {}
            }
        }
    }

    /// Fills in the effects' columns of rows that have been written, with the weights of these rows: a row without
    /// weight stays zero. `of_node`: those of the node's states before, of the first `used` effects; `at_rest`: the
    /// inverse of P, for a node at rest.
    pub fn fill(
        &self,
        (of_node, used): (&[[T; EFFECTS]; NODE], usize),
        further: &mut [[T; EFFECTS]; SCRATCH],
        rows: &[[T; WIDTH]; SCRATCH],
        attitude: &M3<T>,
        pre: &Preintegration<T>,
        at_rest: Option<&M3<T>>,
    ) {
        *further = [[T::ZERO; EFFECTS]; SCRATCH];
        for (row, node) in further.iter_mut().zip(of_node) {
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
        // A limit that the compiler knows: no index has to be checked.
        for column in 0..if used < EFFECTS { used } else { EFFECTS } {
            let rotation = attitude * self.rotation[column];
            put(of_rotation, column, &of_turn, &-rotation);
            put(of_field, column, &of_mean, &-(attitude * self.field[column] * share));
            let (v, p) = (attitude * self.velocity[column], attitude * self.position[column]);
            put(of_velocity, column, &of_speed, &-v);
            put(of_position, column, &of_place, &-p);
            put(of_position, column, &of_place_by_speed, &-v);
            if let Some(inverse) = at_rest {
                put(of_rest, column, &[T::of(REST_WEIGHT); 3], &(inverse * self.rotation[column] * per_second));
            }
        }
    }
}
