#![allow(clippy::indexing_slicing)] // Fixed sizes; every index is bounded by the loops around it.

use crate::algebra::{Packed, dot};

/// Unknowns of the gravity equations: the change of P (row-major, 9) and of c = P b (3).
pub(crate) const GYRO: usize = 12;
/// Unknowns of the field equations: those, the magnetometer's lag behind the gyro (s) and its hard iron (microtesla, 3).
pub(crate) const MAGNETIC: usize = 16;

/// Normal equations of one class of rows, about the nominal model: N x = h, s the sum of squares of the right-hand sides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sums<const D: usize, const T: usize> {
    pub normal: Packed<D, T>,
    pub rhs: [f32; D],
    pub square: f32,
    pub rows: u32,
}

impl<const D: usize, const T: usize> Sums<D, T> {
    pub const fn zero() -> Self {
        Self { normal: Packed::zero(), rhs: [0.0; D], square: 0.0, rows: 0 }
    }

    /// Adds the equations of another stretch of time.
    fn add_sums(&mut self, other: &Self) {
        self.normal.add_scaled(&other.normal, 1.0);
        for (sum, h) in self.rhs.iter_mut().zip(&other.rhs) {
            *sum += h;
        }
        self.square += other.square;
        self.rows += other.rows;
    }

    pub(super) fn add(&mut self, row: &[f32; D], y: f32) {
        self.normal.add_outer(row, 1.0);
        for (sum, a) in self.rhs.iter_mut().zip(row) {
            *sum += a * y;
        }
        self.square += y * y;
        self.rows += 1;
    }

    /// Sum of squared residuals at `x`.
    pub fn misfit(&self, x: &[f32; D]) -> f32 {
        let misfit = self.square - 2.0 * dot(&self.rhs, x) + self.normal.quadratic(x);
        // Cancellation can leave a small negative number.
        if misfit > 0.0 { misfit } else { 0.0 }
    }

    /// Moves the origin of the unknowns by `shift`: x_new = x_old - shift.
    fn recentre(&mut self, shift: &[f32; D]) {
        self.square = self.misfit(shift);
        let change = self.normal.times(shift);
        for (sum, c) in self.rhs.iter_mut().zip(&change) {
            *sum -= c;
        }
    }
}

/// What the moving test windows of one stretch of time say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block {
    pub gravity: Sums<GYRO, 78>,
    pub magnetic: Sums<MAGNETIC, 136>,
    /// Test windows that ended here, moving or not.
    pub windows: u16,
    /// How many of them lacked a rate.
    pub spoilt: u16,
}

impl Block {
    pub const fn zero() -> Self {
        Self { gravity: Sums::zero(), magnetic: Sums::zero(), windows: 0, spoilt: 0 }
    }

    /// Adds the equations of another block.
    pub fn add(&mut self, other: &Self) {
        self.gravity.add_sums(&other.gravity);
        self.magnetic.add_sums(&other.magnetic);
        self.windows += other.windows;
        self.spoilt += other.spoilt;
    }

    /// Share of the test windows that lacked a rate; 0 of none.
    pub fn spoilt_share(&self) -> f32 {
        if self.windows == 0 { 0.0 } else { f32::from(self.spoilt) / f32::from(self.windows) }
    }

    pub const fn is_empty(&self) -> bool {
        self.gravity.rows + self.magnetic.rows == 0
    }

    /// Moves the origin of the gyro's unknowns when another model becomes the nominal one.
    pub fn recentre(&mut self, shift: &[f32; GYRO]) {
        self.gravity.recentre(shift);
        let mut padded = [0.0; MAGNETIC];
        padded[..GYRO].copy_from_slice(shift);
        self.magnetic.recentre(&padded);
    }
}
