//! Rows that the nodes of the last 50 s of motion left over, once their states and the nuisances were eliminated: they
//! depend on P and b alone. The population search minimises their innovations.

use super::{
    columns::{BIAS, GLOBALS, P},
    real::Real,
    rows::{GLOBAL, WIDTH},
    square_root::reflect_first,
};

/// Rows that a node leaves over.
pub(super) const ROWS: usize = 9;
/// Columns of a row: P row-major, b, and a constant.
pub(super) const COLUMNS: usize = 13;
/// Nodes kept unless a build has less room: 50 s of half a second.
pub const WINDOW_NODES: usize = 100;

/// Numbers stored of a node: rotated so that row k begins at column k, which changes no sum of squares.
const KEPT: usize = ROWS * COLUMNS - ROWS * (ROWS - 1) / 2;

/// Ring of the latest nodes' rows, in 16 bits: to 3e-5 of a node's largest coefficient.
#[derive(Clone, Copy)]
pub(super) struct LeftOver<const NODES: usize> {
    rows: [[i16; KEPT]; NODES],
    scales: [f32; NODES],
    next: usize,
    count: usize,
}

impl<const NODES: usize> LeftOver<NODES> {
    pub const fn zero() -> Self {
        Self { rows: [[0; KEPT]; NODES], scales: [0.0; NODES], next: 0, count: 0 }
    }

    pub const fn start(&mut self) {
        (self.next, self.count) = (0, 0);
    }

    /// Number of nodes in the ring.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Takes a node's rows, made about the globals `x`; their constants become those at the prior's mean.
    pub fn push<T: Real>(&mut self, left: &[[T; WIDTH]], x: &[T; GLOBALS]) {
        let mut rows = [[0.0_f32; COLUMNS]; ROWS];
        let mut largest = 0.0_f32;
        for (row, left) in rows.iter_mut().zip(left) {
            let Some((row_constant, row)) = row.split_last_mut() else { break };
            let mut constant = left.last().copied().unwrap_or(T::ZERO);
            let of = |column: usize| left.get(GLOBAL + column).copied().unwrap_or(T::ZERO);
            let columns = P.columns().chain(BIAS.columns());
            for (slot, column) in row.iter_mut().zip(columns) {
                constant -= of(column) * x.get(column).copied().unwrap_or(T::ZERO);
                *slot = of(column).narrow();
            }
            *row_constant = constant.narrow();
        }
        for column in 0..ROWS {
            reflect_first(rows.get_mut(column..).unwrap_or_default(), column);
        }
        let mut is_finite = true;
        for value in rows.as_flattened() {
            let size = libm::fabsf(*value);
            is_finite &= size.is_finite();
            largest = if size > largest { size } else { largest };
        }
        if !(largest > 0.0 && is_finite) {
            return;
        }
        let scale = largest / f32::from(i16::MAX);
        let values = rows.iter().enumerate().flat_map(|(k, row)| row.iter().skip(k));
        let (Some(stored), Some(kept)) = (self.rows.get_mut(self.next), self.scales.get_mut(self.next)) else { return };
        for (stored, value) in stored.iter_mut().zip(values) {
            *stored = libm::roundf(*value / scale) as i16;
        }
        *kept = scale;
        self.next = if self.next + 1 < NODES { self.next + 1 } else { 0 };
        self.count = if self.count < NODES { self.count + 1 } else { NODES };
    }

    /// The rows of one node.
    pub fn node(&self, index: usize) -> [[f32; COLUMNS]; ROWS] {
        let mut rows = [[0.0; COLUMNS]; ROWS];
        let (Some(stored), Some(scale)) = (self.rows.get(index), self.scales.get(index)) else { return rows };
        let slots = rows.iter_mut().enumerate().flat_map(|(k, row)| row.iter_mut().skip(k));
        for (slot, stored) in slots.zip(stored) {
            *slot = f32::from(*stored) * scale;
        }
        rows
    }

    /// Innovations of one node at deviations `x` of P and b.
    pub fn innovations(&self, index: usize, x: &[f32; COLUMNS - 1]) -> [f32; ROWS] {
        let (Some(stored), Some(scale)) = (self.rows.get(index), self.scales.get(index)) else { return [0.0; ROWS] };
        let rest = &mut stored.as_slice();
        let sums = [
            innovation::<12>(rest, x),
            innovation::<11>(rest, x),
            innovation::<10>(rest, x),
            innovation::<9>(rest, x),
            innovation::<8>(rest, x),
            innovation::<7>(rest, x),
            innovation::<6>(rest, x),
            innovation::<5>(rest, x),
            innovation::<4>(rest, x),
        ];
        sums.map(|sum| sum * scale)
    }
}

/// Innovation of the next row, which has `N` coefficients and a constant, at the last `N` of `x`. The compiler knows
/// `N` and unrolls the loop.
#[inline(always)]
fn innovation<const N: usize>(rest: &mut &[i16], x: &[f32; COLUMNS - 1]) -> f32 {
    let Some((row, next)) = rest.split_first_chunk::<N>() else { return 0.0 };
    let Some((constant, next)) = next.split_first() else { return 0.0 };
    *rest = next;
    let x = x.last_chunk::<N>().unwrap_or(&[0.0; N]);
    row.iter().zip(x).fold(f32::from(*constant), |sum, (a, x)| sum + f32::from(*a) * x)
}

#[cfg(test)]
mod tests;
