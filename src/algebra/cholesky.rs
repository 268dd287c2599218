//! Cholesky factor of a small symmetric matrix, N = L L^T, in either width of numbers. It can replace a pivot that
//! rounding made negative. That of packed matrices (`packed_cholesky`) multiplies by inverted diagonals and refuses
//! such a pivot, so that the last bits of the two differ.

use super::real::Real;

/// Lower triangle L of a matrix of at most `N` rows.
pub(crate) struct Cholesky<T, const N: usize> {
    rows: [[T; N]; N],
    count: usize,
}

impl<T: Real, const N: usize> Cholesky<T, N> {
    /// Before a factorisation.
    pub const fn unset() -> Self {
        Self { rows: [[T::ZERO; N]; N], count: 0 }
    }

    /// Factorises the first `count` rows of a matrix, given its lower triangle. `None` where a pivot is not positive.
    pub fn new(count: usize, element: impl Fn(usize, usize) -> T) -> Option<Self> {
        let mut factor = Self::unset();
        factor.factorise(count, element, None)?;
        Some(factor)
    }

    /// Factorises as [`Cholesky::new`], with `least` in place of a pivot that rounding made zero or negative.
    pub fn new_or_least(count: usize, element: impl Fn(usize, usize) -> T, least: T) -> Self {
        let mut factor = Self::unset();
        factor.fill_or_least(count, element, least);
        factor
    }

    /// Factorises in place, for a large matrix: the stack then holds no second one.
    pub fn fill_or_least(&mut self, count: usize, element: impl Fn(usize, usize) -> T, least: T) {
        if self.factorise(count, element, Some(least)).is_none() {
            *self = Self::unset();
        }
    }

    fn factorise(&mut self, count: usize, element: impl Fn(usize, usize) -> T, least: Option<T>) -> Option<()> {
        self.count = if count < N { count } else { N };
        for i in 0..self.count {
            let (above, below) = self.rows.split_at_mut_checked(i)?;
            let row = below.first_mut()?;
            for (j, other) in above.iter().enumerate() {
                let value = less_products(element(i, j), row, other, j) / *other.get(j)?;
                *row.get_mut(j)? = value;
            }
            let sum = less_products(element(i, i), row, row, i);
            *row.get_mut(i)? = if sum > T::ZERO { sum.root() } else { least? };
        }
        Some(())
    }

    /// Element (i, j <= i) of L.
    pub fn at(&self, i: usize, j: usize) -> T {
        self.rows.get(i).and_then(|row| row.get(j)).copied().unwrap_or(T::ZERO)
    }

    /// Solves L y = x in place.
    pub fn solve_lower(&self, x: &mut [T; N]) {
        for (i, row) in self.rows.iter().enumerate().take(self.count) {
            let sum = x.get(i).map_or(T::ZERO, |value| less_products(*value, row, x, i));
            if let Some(value) = x.get_mut(i) {
                *value = sum / self.at(i, i);
            }
        }
    }

    /// Solves L^T y = x in place.
    pub fn solve_upper(&self, x: &mut [T; N]) {
        for i in (0..self.count).rev() {
            let below = x.iter().enumerate().take(self.count).skip(i + 1);
            let sum = below.fold(T::ZERO, |sum, (k, x)| sum + self.at(k, i) * *x);
            if let Some(value) = x.get_mut(i) {
                *value = (*value - sum) / self.at(i, i);
            }
        }
    }

    /// Half of the logarithm of the matrix's determinant.
    pub fn half_log_determinant(&self) -> T {
        (0..self.count).fold(T::ZERO, |sum, i| sum + self.at(i, i).logarithm())
    }

    /// Diagonal element `i` of the matrix's inverse.
    pub fn inverse_diagonal(&self, i: usize) -> T {
        let mut unit = [T::ZERO; N];
        if let Some(one) = unit.get_mut(i) {
            *one = T::ONE;
        }
        self.solve_lower(&mut unit);
        unit.iter().take(self.count).fold(T::ZERO, |sum, x| sum + *x * *x)
    }
}

/// A value less the products of the first `n` elements of two rows.
fn less_products<T: Real>(value: T, a: &[T], b: &[T], n: usize) -> T {
    a.iter().zip(b).take(n).fold(value, |sum, (a, b)| sum - *a * *b)
}

#[cfg(test)]
mod tests;
