//! The inverse of the root of the globals' information: its columns give any element of their covariance.

use crate::estimator::{columns::GLOBALS, gaussian::triangle, globals::WIDE, real::Real};

/// The inverse of a triangular root, column by column: packed, element (row i, column c) at (c, i) of a lower triangle.
pub(super) fn invert<T: Real>(root: &[[T; WIDE]; GLOBALS], inverse: &mut [T]) {
    let mut rest = inverse;
    for c in 0..GLOBALS {
        let Some((own, next)) = core::mem::take(&mut rest).split_at_mut_checked(c + 1) else { return };
        for i in (0..=c).rev() {
            let unit = if i == c { T::ONE } else { T::ZERO };
            let Some(row) = root.get(i) else { return };
            let known = row.iter().zip(own.iter()).skip(i + 1);
            let sum = known.fold(unit, |sum, (a, x)| sum - *a * *x);
            if let (Some(slot), Some(diagonal)) = (own.get_mut(i), row.get(i)) {
                *slot = sum / *diagonal;
            }
        }
        rest = next;
    }
}

/// Column `c` of the inverse, down to its diagonal. The covariance is the sum of the columns' outer products.
pub(super) fn column<T>(inverse: &[T], c: usize) -> &[T] {
    inverse.get(triangle(c)..triangle(c + 1)).unwrap_or_default()
}

#[cfg(test)]
mod tests;
