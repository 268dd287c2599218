//! The rows that the nodes of the last 50 s of motion left over, when their states and the nuisances were eliminated: what each says of P and b
//! alone. For the population search.

#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use super::{
    columns::{BIAS, GLOBALS, P},
    globals::WIDE,
    real::Real,
};

/// Rows of a node.
pub(super) const ROWS: usize = 9;
/// P row-major, b, and a constant.
pub(super) const COLUMNS: usize = 13;
/// Nodes kept: 50 s of half a second.
pub(super) const NODES: usize = 100;

/// A ring of them, in 16 bits: to 3e-5 of a node's largest coefficient.
#[derive(Clone, Copy)]
pub(super) struct LeftOver {
    rows: [[[i16; COLUMNS]; ROWS]; NODES],
    scales: [f32; NODES],
    next: usize,
    count: usize,
}

impl LeftOver {
    pub const fn zero() -> Self {
        Self { rows: [[[0; COLUMNS]; ROWS]; NODES], scales: [0.0; NODES], next: 0, count: 0 }
    }

    pub const fn start(&mut self) {
        (self.next, self.count) = (0, 0);
    }

    /// Nodes in it.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Takes a node's rows, made about the globals `x`; their constants become those at the prior's mean.
    pub fn push<T: Real>(&mut self, left: &[[T; WIDE]], x: &[T; GLOBALS]) {
        let mut rows = [[0.0_f32; COLUMNS]; ROWS];
        let mut largest = 0.0_f32;
        for (row, left) in rows.iter_mut().zip(left) {
            let mut constant = left[GLOBALS];
            let columns = P.columns().chain(BIAS.columns());
            for (slot, column) in row.iter_mut().zip(columns) {
                constant -= left[column] * x[column];
                *slot = left[column].narrow();
            }
            row[COLUMNS - 1] = constant.narrow();
            for value in row.iter() {
                let size = libm::fabsf(*value);
                // A NaN stays out.
                largest = if size > largest { size } else { largest };
            }
        }
        if !(largest > 0.0 && largest.is_finite()) {
            return;
        }
        let scale = largest / f32::from(i16::MAX);
        for (stored, row) in self.rows[self.next].iter_mut().zip(&rows) {
            for (stored, value) in stored.iter_mut().zip(row) {
                *stored = libm::roundf(*value / scale) as i16;
            }
        }
        self.scales[self.next] = scale;
        self.next = (self.next + 1) % NODES;
        self.count = if self.count < NODES { self.count + 1 } else { NODES };
    }

    /// The rows of one node.
    pub fn node(&self, index: usize) -> [[f32; COLUMNS]; ROWS] {
        let scale = self.scales.get(index).copied().unwrap_or(0.0);
        self.rows
            .get(index)
            .map_or([[0.0; COLUMNS]; ROWS], |rows| rows.map(|row| row.map(|stored| f32::from(stored) * scale)))
    }

    /// Innovations of one node at deviations `x` of P and b.
    pub fn innovations(&self, index: usize, x: &[f32; COLUMNS - 1]) -> [f32; ROWS] {
        let (Some(rows), Some(scale)) = (self.rows.get(index), self.scales.get(index)) else { return [0.0; ROWS] };
        let mut innovations = [0.0; ROWS];
        for (innovation, row) in innovations.iter_mut().zip(rows) {
            let sum = row.iter().zip(x).fold(f32::from(row[COLUMNS - 1]), |sum, (a, x)| sum + f32::from(*a) * x);
            *innovation = sum * scale;
        }
        innovations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_those_at_the_priors_mean_and_the_oldest_node_goes() {
        let mut ring = LeftOver::zero();
        let mut x = [0.0_f64; GLOBALS];
        (x[P.from + 2], x[BIAS.from]) = (0.5, -1.0);
        for node in 0..NODES + 3 {
            let mut left = [[0.0_f64; WIDE]; ROWS];
            left[4][P.from + 2] = 10.0;
            left[4][BIAS.from] = 4.0;
            left[4][GLOBALS] = node as f64;
            ring.push(&left, &x);
        }
        assert_eq!(ring.count(), NODES);
        let mut at = [0.0; 12];
        (at[2], at[9]) = (0.5, -1.0);
        for (index, node) in [(0, NODES), (2, NODES + 2), (3, 3), (NODES - 1, NODES - 1)] {
            let innovation = ring.innovations(index, &at)[4];
            assert!((innovation - node as f32).abs() < 0.01 * (1.0 + node as f32), "{index}: {innovation}");
            assert!((ring.node(index)[4][12] - (node as f32 - 1.0)).abs() < 0.01 * (1.0 + node as f32));
        }
    }
}
