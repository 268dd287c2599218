//! The update that brings the states of a node to the next: its rows, and the elimination of the states.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    candidates::Candidates,
    columns::{GLOBALS, NODE, POSITION, VELOCITY},
    node::{Kind, Node},
    reading::{
        Agreement, Predicted, Readings, Seen, Taken, is_path_contradicted, path_noise, peak, predict, refer, rotate,
        see, weight,
    },
    real::{Real, zero3, zero33},
    rows::{self, Block, CONSTANT, GLOBAL, NEW, REST_WEIGHT, ROWS, SCRATCH, WIDTH},
};

/// Bound of the speed at rest, m/s.
const REST_SPEED_M_S: f32 = 0.01;

/// Blocks of three new rows that have a constant, by index: read field, bounds of velocity and position, rest.
#[cfg(feature = "explanation")]
pub(super) const FIELD_READ: usize = 1;
#[cfg(feature = "explanation")]
pub(super) const VELOCITY_BOUND: usize = 5;
#[cfg(feature = "explanation")]
pub(super) const POSITION_BOUND: usize = 6;
#[cfg(feature = "explanation")]
pub(super) const BY_REST: usize = 7;

/// An update in progress, column by column.
#[derive(Clone, Copy)]
pub(super) struct Update<T> {
    /// Rows of the old root, then the new ones; before and after an update scratch memory.
    pub rows: [[T; WIDTH]; SCRATCH],
    next: usize,
    predicted: Predicted<T>,
}

impl<T: Real> Update<T> {
    pub const fn zero() -> Self {
        Self {
            rows: [[T::ZERO; WIDTH]; SCRATCH],
            next: 0,
            predicted: Predicted { attitude: zero33(), velocity: zero3(), position: zero3() },
        }
    }

    /// Writes the rows of a node.
    pub fn assemble(&mut self, node: &mut Node<T>, taken: &Taken<T>) -> Agreement<T> {
        self.rows.iter_mut().take(NODE + ROWS).for_each(|row| *row = [T::ZERO; WIDTH]);
        self.next = 0;
        for (row, root) in self.rows.iter_mut().zip(&node.root) {
            row[..NODE].copy_from_slice(&root[..NODE]);
            row[GLOBAL..CONSTANT].copy_from_slice(&root[NODE..]);
        }
        self.predicted = predict(node, taken);
        node.choose_point(taken.kind, taken.pre.angle);
        let (_, new) = self.rows.split_at_mut(NODE);
        let (blocks, _) = new.as_chunks_mut::<3>();
        let [rotated, seen, first, second, walked, slow, near, still, ..] = blocks else {
            return Agreement {
                field: Readings::Missing,
                force: Readings::Missing,
                is_turned: false,
                innovation: None,
            };
        };
        let Taken { pre, settings, sigma, .. } = *taken;
        let noise = &settings.noise;

        rotate(rotated, node, taken);
        let Seen { readings: field, is_turned, innovation } = see(seen, node, taken);
        let walk = if taken.kind == Kind::Rest { 0.0 } else { noise.field_walk_rts * noise.field_walk_rts };
        let variance = T::of(walk + 1e-8) * pre.seconds;
        rows::field_walk(Block { rows: walked, weight: weight(variance / peak(noise)), sigma });

        let speed = T::of(if taken.kind == Kind::Rest { REST_SPEED_M_S } else { noise.velocity_m_s });
        let mut force = if pre.forces == pre.increments { Readings::Used } else { Readings::Missing };
        if force == Readings::Used {
            let mut path = [[T::ZERO; WIDTH]; 6];
            // By hand the force holds the attitude while a field is wrong for long, and must not be left out.
            let is_bounded = noise.acceleration_m_s_rts > 0.0;
            if is_bounded && is_path_contradicted(&mut path, node, taken, &self.predicted.velocity, speed) {
                force = Readings::Contradicted;
            } else {
                let path_noise = path_noise(taken, &self.predicted.velocity, speed);
                rows::path(&mut path, sigma, &node.linear_at, pre, &path_noise);
                for (slot, row) in first.iter_mut().chain(second).zip(&path) {
                    *slot = *row;
                }
            }
        }
        if force != Readings::Used {
            (self.predicted.velocity, self.predicted.position) = (zero3(), zero3());
        }
        rows::bounds(Block { rows: slow, weight: T::ONE / speed, sigma }, VELOCITY, &self.predicted.velocity);
        let block = Block { rows: near, weight: T::of(1.0 / noise.position_m), sigma };
        rows::bounds(block, POSITION, &self.predicted.position);
        if taken.kind == Kind::Rest {
            let (_, rate) = pre.rate_statistics();
            let block = Block { rows: still, weight: T::of(REST_WEIGHT), sigma };
            rows::rest(block, &(rate - taken.parameters.bias - taken.parameters.turned_back(&pre.mean_taken_out())));
        } else if field == Readings::Used {
            refer(still, node, taken);
        }
        Agreement { field, force, is_turned, innovation }
    }

    /// Eliminates the next two columns; `false` when all states are done. The rows from [`Update::left_over`] then say
    /// what the node says of the globals.
    pub fn eliminate<const E: usize>(
        &mut self,
        candidates: &Candidates<T, E>,
        further: &mut [[T; E]; SCRATCH],
    ) -> bool {
        if self.next >= 2 * NODE {
            return false;
        }
        candidates.eliminate(further, &mut self.rows, self.next);
        self.next += 2;
        true
    }

    /// Returns true if the rows have been written and none of their states is eliminated.
    #[cfg(feature = "explanation")]
    pub const fn is_fresh(&self) -> bool {
        self.next == 0
    }

    /// Sets all constants to zero but those of one block of three rows.
    #[cfg(feature = "explanation")]
    pub fn keep_constants(&mut self, block: usize) {
        let kept = NODE + 3 * block..NODE + 3 * block + 3;
        for (index, row) in self.rows.iter_mut().enumerate() {
            if !kept.contains(&index) {
                row[CONSTANT] = T::ZERO;
            }
        }
    }

    /// Rows of the globals alone, once the states are eliminated.
    pub fn left_over(&mut self) -> &mut [[T; WIDTH]] {
        self.rows.get_mut(2 * NODE..NODE + ROWS).unwrap_or_default()
    }

    /// Sum of the squared innovations, once the globals have all their columns: chi-square of the rows less the states.
    pub fn innovation(&self) -> T {
        let left = self.rows.get(2 * NODE..NODE + ROWS).unwrap_or_default();
        left.iter().fold(T::ZERO, |sum, row| sum + row[CONSTANT] * row[CONSTANT])
    }

    /// Moves the states, given the change of the globals.
    pub fn finish(&self, node: &mut Node<T>, change: &[T; GLOBALS]) {
        let rows = &self.rows[NODE..2 * NODE];
        let mut by = [T::ZERO; NODE];
        for j in (0..NODE).rev() {
            let row = &rows[j];
            let mut sum = -row[CONSTANT];
            for c in 0..GLOBALS {
                sum -= row[GLOBAL + c] * change[c];
            }
            for c in j + 1..NODE {
                sum -= row[NEW + c] * by[c];
            }
            by[j] = sum / row[NEW + j];
        }
        for (root, row) in node.root.iter_mut().zip(rows) {
            root[..NODE].copy_from_slice(&row[NEW..NEW + NODE]);
            root[NODE..].copy_from_slice(&row[GLOBAL..CONSTANT]);
        }
        (node.attitude, node.velocity, node.position) =
            (self.predicted.attitude, self.predicted.velocity, self.predicted.position);
        node.move_by(&by);
    }
}
