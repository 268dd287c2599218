//! Gate of a node's readings: three innovations are held against the covariance of all the unknowns and their own
//! noise.

// Fixed sizes; every index is bounded by the loops around it.
#![allow(clippy::indexing_slicing, clippy::needless_range_loop)]

use super::{
    columns::{ATTITUDE, GLOBALS, NODE},
    globals::Globals,
    node::Node,
    real::{M3, Real, V3, square, zero33},
    rows::{CONSTANT, GLOBAL, WIDTH},
};
use crate::algebra::cholesky::Cholesky;

/// Chi-square of three innovations above which they contradict: one in 10,000 does by chance.
const CONTRADICTED: f32 = 21.1;
/// Square of one innovation, over its variance, above which it contradicts: one in 1,000 does by chance.
const CONTRADICTED_ALONG: f32 = 10.8;

/// Returns true if three independent innovations of variance 1 can contradict. Unknowns that are uncertain only make
/// large innovations likelier: if this is false, the unknowns' covariance need not be computed.
pub(super) fn may_contradict<T: Real>(value: &V3<T>) -> bool {
    // A NaN returns true: the covariance decides.
    let is_likely = square(value) <= T::of(CONTRADICTED);
    !is_likely
}

/// Innovations and the covariance that the unknowns give them, over the variance of the readings' own noise.
pub(super) struct Innovation<T> {
    value: V3<T>,
    covariance: M3<T>,
}

impl<T: Real> Innovation<T> {
    /// Makes the innovation of three rows on old states and globals, weighted with their own noise.
    pub fn new(rows: &[[T; WIDTH]], node: &Node<T>, globals: &Globals<T>) -> Self {
        // R^-T h of the three rows' coefficients h, element by element: each of R's is then read once for all three.
        let mut solved = [[T::ZERO; 3]; NODE + GLOBALS];
        let mut value = V3::new(T::ZERO, T::ZERO, T::ZERO);
        for (axis, (row, value)) in rows.iter().zip(value.iter_mut()).enumerate() {
            let coefficients = row[..NODE].iter().chain(&row[GLOBAL..CONSTANT]);
            solved.iter_mut().zip(coefficients).for_each(|(y, x)| y[axis] = *x);
            *value = row[CONSTANT];
        }
        for j in (0..NODE + GLOBALS).step_by(COLUMNS) {
            if j + COLUMNS <= NODE + GLOBALS {
                solve::<T, COLUMNS>(&mut solved, node, globals, j);
            } else {
                (j..NODE + GLOBALS).for_each(|j| solve::<T, 1>(&mut solved, node, globals, j));
            }
        }
        let mut covariance = zero33();
        for i in 0..3 {
            for j in 0..=i {
                let product = solved.iter().fold(T::ZERO, |sum, y| sum + y[i] * y[j]);
                (covariance[(i, j)], covariance[(j, i)]) = (product, product);
            }
        }
        Self { value, covariance }
    }

    /// Returns true if the innovations are larger than chance makes them, with readings of so many times the rows'
    /// variance.
    pub fn is_contradicted(&self, noise: T) -> bool {
        square(&self.in_deviations(noise)) > T::of(CONTRADICTED)
    }

    /// The innovations in units of their deviations: without correlation, and of variance 1.
    pub fn in_deviations(&self, noise: T) -> V3<T> {
        let of = |i: usize, j: usize| -> T { self.covariance.get((i, j)).map_or(T::ZERO, |x: &T| *x) };
        let with_noise = |i: usize, j: usize| of(i, j) + if i == j { noise } else { T::ZERO };
        let mut solved = [self.value.x, self.value.y, self.value.z];
        // With their own noise in, it is positive definite.
        let factor = Cholesky::<T, 3>::new_or_least(3, with_noise, noise.root());
        factor.solve_lower(&mut solved);
        solved.into()
    }

    /// Returns true if an innovation along a direction (of length 1), weighted as the rows are, is larger than chance
    /// makes it, with readings of so many times the rows' variance.
    pub fn is_contradicted_along(&self, direction: &V3<T>, innovation: T, noise: T) -> bool {
        let variance = direction.dot(&(self.covariance * direction)) + noise;
        innovation * innovation > T::of(CONTRADICTED_ALONG) * variance
    }
}

/// Sum of the variances of the attitude's errors about the axes of the earth, rad^2.
pub(super) fn attitude_variance<T: Real>(node: &Node<T>, globals: &Globals<T>) -> T {
    let mut rows = [[T::ZERO; WIDTH]; 3];
    for (i, row) in rows.iter_mut().enumerate() {
        row[ATTITUDE + i] = T::ONE;
    }
    Innovation::new(&rows, node, globals).covariance.trace()
}

/// Columns of the root that are solved together: what is read of the rows above then serves all. A divisor of the
/// number of states.
const COLUMNS: usize = 4;

/// Solves the elements from `j` on of three right-hand sides, those above being solved: `B` columns, all of states or
/// all of globals.
fn solve<T: Real, const B: usize>(
    solved: &mut [[T; 3]; NODE + GLOBALS],
    node: &Node<T>,
    globals: &Globals<T>,
    j: usize,
) {
    let Some((above, own)) = solved.split_at_mut_checked(j) else { return };
    let Some(own) = own.first_chunk_mut::<B>() else { return };
    let mut y = *own;
    for (known, row) in above.iter().zip(&node.root) {
        less(&mut y, known, row, j);
    }
    let is_global = j >= NODE;
    let at = if is_global { j - NODE } else { j };
    for (known, row) in above.iter().skip(NODE).zip(&globals.root) {
        less(&mut y, known, row, at);
    }
    for k in 0..B {
        let row = if is_global {
            globals.root.get(at + k).map(|row| &row[..])
        } else {
            node.root.get(at + k).map(|row| &row[..])
        };
        let Some(row) = row.and_then(|row| row.get(at..)).and_then(|row| row.first_chunk::<B>()) else { return };
        let known = y[k].map(|y| y / row[k]);
        y[k] = known;
        for (y, factor) in y.iter_mut().zip(row).skip(k + 1) {
            for (y, known) in y.iter_mut().zip(&known) {
                *y -= *known * *factor;
            }
        }
    }
    *own = y;
}

/// Subtracts a solved element of each right-hand side times a row of the root, from a column on.
#[inline(always)]
fn less<T: Real, const B: usize>(y: &mut [[T; 3]; B], known: &[T; 3], row: &[T], from: usize) {
    let Some(factors) = row.get(from..).and_then(|row| row.first_chunk::<B>()) else { return };
    for (y, factor) in y.iter_mut().zip(factors) {
        for (y, known) in y.iter_mut().zip(known) {
            *y -= *known * *factor;
        }
    }
}

#[cfg(test)]
mod tests;
