//! Globals: their deviations from the prior's mean in units of the prior's width, and the root of their information,
//! the prior inside. A column of width 0 is not in use: no row has a coefficient for it.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    columns::{GLOBALS, NUISANCES},
    real::Real,
    unrolled::add_times,
};

/// Elements of a row: the globals and a constant.
pub(super) const WIDE: usize = GLOBALS + 1;

#[derive(Clone, Copy)]
pub(super) struct Globals<T> {
    pub x: [T; GLOBALS],
    /// Upper triangular; the constants are zero between updates.
    pub root: [[T; WIDE]; GLOBALS],
}

impl<T: Real> Globals<T> {
    pub const fn zero() -> Self {
        Self { x: [T::ZERO; GLOBALS], root: [[T::ZERO; WIDE]; GLOBALS] }
    }

    /// Resets every global to its prior: mean 0 and deviation 1, in units of the prior's width.
    pub fn start(&mut self) {
        *self = Self::zero();
        for (i, row) in self.root.iter_mut().enumerate() {
            row[i] = T::ONE;
        }
    }

    /// Returns true if every number is finite and every global has some information.
    #[inline(never)]
    pub fn is_root(&self) -> bool {
        let mut numbers = self.x.iter().chain(self.root.as_flattened());
        let mut diagonal = self.root.iter().enumerate().filter_map(|(i, row)| row.get(i));
        numbers.all(|x| x.is_finite()) && diagonal.all(|x| *x * *x > T::ZERO)
    }

    /// Moves the globals to the optimum and returns by how much.
    pub fn solve(&mut self) -> [T; GLOBALS] {
        let mut by = [T::ZERO; GLOBALS];
        for j in (0..GLOBALS).rev() {
            let row = &mut self.root[j];
            let mut sum = -row[GLOBALS];
            for c in j + 1..GLOBALS {
                sum -= row[c] * by[c];
            }
            by[j] = sum / row[j];
            row[GLOBALS] = T::ZERO;
        }
        for (x, by) in self.x.iter_mut().zip(&by) {
            *x += *by;
        }
        by
    }

    /// Variance of a quantity that depends on bias and P alone, by these derivatives, in units of the prior's widths.
    // Once in the program: it is called a few times a node.
    #[inline(never)]
    pub fn variance(&self, by: &[T; GLOBALS - NUISANCES]) -> T {
        // The squared length of R^-T d.
        let mut solved = *by;
        let mut sum = T::ZERO;
        for i in 0..solved.len() {
            let row = &self.root[NUISANCES + i];
            let x = solved[i] / row[NUISANCES + i];
            sum += x * x;
            for j in i + 1..solved.len() {
                solved[j] -= row[NUISANCES + j] * x;
            }
        }
        sum
    }

    /// Vector and factor of process noise: C + q e e^T, noise of variance q (in squared units of the prior's width) on
    /// one global, is, of the information's root, (I - beta u u^T) R with u = R e. Returns `None` for no noise.
    pub fn process_noise(&self, global: usize, variance: T) -> Option<([T; GLOBALS], T)> {
        if variance <= T::ZERO {
            return None;
        }
        let mut u = [T::ZERO; GLOBALS];
        for (u, row) in u.iter_mut().zip(&self.root) {
            *u = row.get(global).copied().unwrap_or(T::ZERO);
        }
        let square = u.iter().fold(T::ZERO, |sum, u| sum + *u * *u);
        (square > T::ZERO).then(|| (u, (T::ONE - (T::ONE / (T::ONE + variance * square)).root()) / square))
    }

    /// Multiplies the root by I - beta u u^T. Leaves it full: it has to be made triangular afterwards, column by
    /// column.
    pub fn add_process_noise(&mut self, u: &[T; GLOBALS], beta: T) {
        let mut dots = [T::ZERO; GLOBALS];
        for (u, row) in u.iter().zip(&self.root) {
            add_times(&mut dots, *u, row);
        }
        for (u, row) in u.iter().zip(&mut self.root) {
            add_times(row, -(beta * *u), &dots);
        }
    }

    /// One global drifted: x' = kept x + w, where w has the variance 1 - kept^2 in squared units of the prior's
    /// width, so that a kept share of 1 changes nothing and one of 0 leaves the prior. What is known of the others
    /// stays, and so does the triangle.
    pub fn relax(&mut self, global: usize, kept: T) {
        if kept >= T::ONE || global >= GLOBALS {
            return;
        }
        // Turns all information on the global into its own row.
        for i in (0..global).rev() {
            self.rotate(global, i, global);
        }
        // With x = (x' - w) / kept the row's noise is no longer 1.
        let own = &mut self.root[global];
        let lost = T::ONE - kept * kept;
        let scale = T::ONE / (kept * kept + own[global] * own[global] * lost).root();
        for (c, x) in own.iter_mut().enumerate() {
            *x *= if c == global { scale } else { scale * kept };
        }
        self.x[global] *= kept;
        for i in 0..global {
            self.rotate(i, global, i);
        }
    }

    /// Turns two rows so that the second has nothing in a column (a Givens rotation).
    fn rotate(&mut self, into: usize, from: usize, column: usize) {
        let (a, b) = (self.root[into][column], self.root[from][column]);
        if b == T::ZERO {
            return;
        }
        let norm = (a * a + b * b).root();
        let (c, s) = (a / norm, b / norm);
        for k in 0..WIDE {
            let (a, b) = (self.root[into][k], self.root[from][k]);
            self.root[into][k] = c * a + s * b;
            self.root[from][k] = c * b - s * a;
        }
        self.root[from][column] = T::ZERO;
    }
}

#[cfg(test)]
mod tests;
