#![allow(clippy::indexing_slicing, clippy::needless_range_loop)] // Fixed sizes; every index is bounded by the loops around it.

/// A symmetric D x D matrix, lower triangle row by row: element (i, j <= i) at i (i + 1) / 2 + j. `T` must be D (D + 1) / 2.
#[derive(Clone, Copy, Debug)]
pub struct Packed<const D: usize, const T: usize>(pub(crate) [f32; T]);

/// Lower Cholesky factor L of a positive-definite matrix N = L L^T, packed as [`Packed`], with the diagonal inverted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cholesky<const D: usize, const T: usize>([f32; T]);

const fn at(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

/// Element (i, j <= i). The triangle's index is beyond what the compiler can bound, so an index out of range, which the sizes
/// exclude, reads 0 instead of panicking.
fn read(elements: &[f32], i: usize, j: usize) -> f32 {
    elements.get(at(i, j)).copied().unwrap_or(0.0)
}

fn write(elements: &mut [f32], i: usize, j: usize, value: f32) {
    if let Some(element) = elements.get_mut(at(i, j)) {
        *element = value;
    }
}

impl<const D: usize, const T: usize> Packed<D, T> {
    const SIZES_AGREE: () = assert!(T == D * (D + 1) / 2);

    /// The zero matrix. Does not compile when `T` is not D (D + 1) / 2.
    #[must_use]
    pub const fn zero() -> Self {
        #[allow(clippy::let_unit_value)]
        let () = Self::SIZES_AGREE;
        Self([0.0; T])
    }

    /// Element (i, j); 0 out of range.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> f32 {
        if j <= i { read(&self.0, i, j) } else { read(&self.0, j, i) }
    }

    /// Adds `value` to element (i, j) and, being symmetric, (j, i).
    pub fn add(&mut self, i: usize, j: usize, value: f32) {
        let (i, j) = if j <= i { (i, j) } else { (j, i) };
        let sum = read(&self.0, i, j) + value;
        write(&mut self.0, i, j, sum);
    }

    /// Adds `weight * row row^T`.
    pub fn add_outer(&mut self, row: &[f32; D], weight: f32) {
        let mut rest = self.0.as_mut_slice();
        for (i, factor) in row.iter().enumerate() {
            let Some((sums, next)) = core::mem::take(&mut rest).split_at_mut_checked(i + 1) else { return };
            let scaled = weight * factor;
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += scaled * value;
            }
            rest = next;
        }
    }

    /// Adds `weight * row row^T` of three rows: each sum is read and written once.
    pub(crate) fn add_outers(&mut self, rows: &[[f32; D]; 3], weight: f32) {
        let [a, b, c] = rows;
        let mut rest = self.0.as_mut_slice();
        for i in 0..D {
            let Some((sums, next)) = core::mem::take(&mut rest).split_at_mut_checked(i + 1) else { return };
            let (wa, wb, wc) = (weight * a[i], weight * b[i], weight * c[i]);
            for (((sum, x), y), z) in sums.iter_mut().zip(a).zip(b).zip(c) {
                *sum += wa * x + wb * y + wc * z;
            }
            rest = next;
        }
    }

    /// Multiplies every element.
    pub(crate) fn scale(&mut self, factor: f32) {
        for a in &mut self.0 {
            *a *= factor;
        }
    }

    /// Adds `weight * other`.
    pub(crate) fn add_scaled(&mut self, other: &Self, weight: f32) {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a += weight * b;
        }
    }

    /// Adds `weight * block` to the elements of the first variables, row by row as both are packed.
    pub(crate) fn add_leading<const E: usize, const U: usize>(&mut self, block: &Packed<E, U>, weight: f32) {
        for (a, b) in self.0.iter_mut().zip(&block.0) {
            *a += weight * b;
        }
    }

    pub(crate) fn times(&self, x: &[f32; D]) -> [f32; D] {
        let mut y = [0.0; D];
        let mut rest = self.0.as_slice();
        for (i, own) in x.iter().enumerate() {
            let Some((row, next)) = rest.split_at_checked(i + 1) else { return y };
            let Some((diagonal, below)) = row.split_last() else { return y };
            let mut sum = diagonal * own;
            for ((a, x), y) in below.iter().zip(x).zip(&mut y) {
                sum += a * x;
                *y += a * own;
            }
            y[i] += sum;
            rest = next;
        }
        y
    }

    /// x^T N x.
    pub(crate) fn quadratic(&self, x: &[f32; D]) -> f32 {
        let mut rest = self.0.as_slice();
        let mut total = 0.0;
        for (i, own) in x.iter().enumerate() {
            let Some((row, next)) = rest.split_at_checked(i + 1) else { return total };
            let Some((diagonal, below)) = row.split_last() else { return total };
            let sum = below.iter().zip(x).fold(0.0, |sum, (a, x)| sum + a * x);
            total += own * (2.0 * sum + diagonal * own);
            rest = next;
        }
        total
    }

    /// Sum over all elements of the product with another matrix: the trace of N M.
    pub(crate) fn inner(&self, other: &Self) -> f32 {
        let mut sum = 0.0;
        for i in 0..D {
            for j in 0..i {
                sum += 2.0 * read(&self.0, i, j) * read(&other.0, i, j);
            }
            sum += read(&self.0, i, i) * read(&other.0, i, i);
        }
        sum
    }

    /// Fixes parameter `i`: its row and column become those of the identity, so that its solution is its right-hand side.
    pub(crate) fn freeze(&mut self, i: usize) {
        for j in 0..D {
            let (row, column) = if j <= i { (i, j) } else { (j, i) };
            write(&mut self.0, row, column, if i == j { 1.0 } else { 0.0 });
        }
    }

    /// The Cholesky factor; `None` when the matrix is not positive definite to f32's precision, or not finite.
    pub(crate) fn cholesky(&self) -> Option<Cholesky<D, T>> {
        let mut l = self.0;
        for i in 0..D {
            // Rows lie one after the other, so that the sums run along slices.
            let (above, below) = l.split_at_mut_checked(at(i, 0))?;
            let row = below.get_mut(..=i)?;
            for j in 0..=i {
                let (done, rest) = row.split_at_mut_checked(j)?;
                let element = rest.first_mut()?;
                if i == j {
                    let sum = *element - done.iter().fold(0.0, |sum, x| sum + x * x);
                    // Pivots that lose all but the last few bits of their diagonal are rounding noise (f32: 2^-24 each of D terms).
                    let floor = *element * 1e-6;
                    if !(sum > floor && sum.is_finite()) {
                        return None;
                    }
                    *element = 1.0 / libm::sqrtf(sum);
                } else {
                    let other = above.get(at(j, 0)..=at(j, j))?;
                    let (factors, inverse) = other.split_at_checked(j)?;
                    let sum = *element - done.iter().zip(factors).fold(0.0, |sum, (x, y)| sum + x * y);
                    *element = sum * inverse.first()?;
                }
            }
        }
        Some(Cholesky(l))
    }
}

impl<const D: usize, const T: usize> Cholesky<D, T> {
    /// x with N x = rhs.
    pub fn solve(&self, rhs: &[f32; D]) -> [f32; D] {
        self.solve_upper(&self.solve_lower(rhs))
    }

    /// y with L y = rhs.
    pub fn solve_lower(&self, rhs: &[f32; D]) -> [f32; D] {
        let mut y = *rhs;
        for i in 0..D {
            let row = self.0.get(at(i, 0)..=at(i, i)).unwrap_or_default();
            let sum = row.iter().zip(&y).take(i).fold(y[i], |sum, (l, y)| sum - l * y);
            y[i] = sum * row.last().copied().unwrap_or(0.0);
        }
        y
    }

    /// x with L^T x = rhs: maps whitened coordinates to parameters.
    pub fn solve_upper(&self, rhs: &[f32; D]) -> [f32; D] {
        let mut x = *rhs;
        for i in (0..D).rev() {
            let row = self.0.get(at(i, 0)..=at(i, i)).unwrap_or_default();
            let value = x[i] * row.last().copied().unwrap_or(0.0);
            // What is known is taken off the others, along the row.
            for (x, l) in x.iter_mut().zip(row).take(i) {
                *x -= l * value;
            }
            x[i] = value;
        }
        x
    }

    /// L^T x: maps parameters to whitened coordinates.
    pub fn times_upper(&self, x: &[f32; D]) -> [f32; D] {
        let mut y = [0.0; D];
        for i in 0..D {
            y[i] = x[i] / read(&self.0, i, i);
            for k in i + 1..D {
                y[i] += read(&self.0, k, i) * x[k];
            }
        }
        y
    }
}

/// a + b.
pub(crate) fn plus<const D: usize>(a: &[f32; D], b: &[f32; D]) -> [f32; D] {
    let mut sum = *a;
    for (x, y) in sum.iter_mut().zip(b) {
        *x += y;
    }
    sum
}

/// a - b.
pub(crate) fn minus<const D: usize>(a: &[f32; D], b: &[f32; D]) -> [f32; D] {
    let mut difference = *a;
    for (x, y) in difference.iter_mut().zip(b) {
        *x -= y;
    }
    difference
}

pub(crate) fn dot<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    fn random_rows(seed: u64) -> [[f32; 5]; 9] {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        [[0.0; 5]; 9].map(|row| row.map(|_: f32| generator.next_u32() as f32 / u32::MAX as f32 - 0.5))
    }

    #[test]
    fn solving_undoes_multiplying() {
        for seed in 0..50 {
            let mut n = Packed::<5, 15>::zero();
            for row in random_rows(seed) {
                n.add_outer(&row, 2.0);
            }
            let x = random_rows(seed + 1000)[0];
            let l = n.cholesky().unwrap();
            for (solved, expected) in l.solve(&n.times(&x)).iter().zip(&x) {
                assert!((solved - expected).abs() < 2e-3, "{solved} {expected}");
            }
            let whitened = l.times_upper(&x);
            for (back, expected) in l.solve_upper(&whitened).iter().zip(&x) {
                assert!((back - expected).abs() < 1e-5);
            }
            let mut outer = Packed::<5, 15>::zero();
            outer.add_outer(&x, 1.0);
            assert!((outer.inner(&n) - n.quadratic(&x)).abs() < 1e-4, "trace of x x^T N");
            // |L^T x|^2 = x^T N x
            assert!((dot(&whitened, &whitened) - n.quadratic(&x)).abs() < 1e-5);
        }
    }

    #[test]
    fn a_frozen_parameter_keeps_its_right_hand_side_and_the_others_solve_without_it() {
        let mut n = Packed::<5, 15>::zero();
        for row in random_rows(7) {
            n.add_outer(&row, 1.0);
        }
        n.freeze(2);
        let x = n.cholesky().unwrap().solve(&[1.0, 2.0, 0.0, 4.0, 5.0]);
        assert_eq!(x[2], 0.0);
        for (i, value) in n.times(&x).iter().enumerate().filter(|(i, _)| *i != 2) {
            assert!((value - [1.0, 2.0, 0.0, 4.0, 5.0][i]).abs() < 1e-3);
        }
    }

    #[test]
    fn a_singular_or_non_finite_matrix_has_no_factor() {
        let mut n = Packed::<5, 15>::zero();
        assert!(n.cholesky().is_none());
        n.add_outer(&[1.0, 2.0, 3.0, 4.0, 5.0], 1.0);
        assert!(n.cholesky().is_none());
        n.add(0, 0, f32::NAN);
        assert!(n.cholesky().is_none());
    }
}
