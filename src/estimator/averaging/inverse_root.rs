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
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    #[test]
    fn covariance_times_information_is_one() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut root = [[0.0_f64; WIDE]; GLOBALS];
        for (i, row) in root.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate().take(GLOBALS).skip(i) {
                let random = f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5;
                *element = if i == j { 1.0 + random } else { 0.3 * random };
            }
        }
        let information =
            |a: usize, b: usize| root.iter().map(|row| row.get(a).unwrap() * row.get(b).unwrap()).sum::<f64>();
        let mut inverse = [0.0; triangle(GLOBALS)];
        invert(&root, &mut inverse);
        let covariance = |a: usize, b: usize| -> f64 {
            let of = |c: usize, row: usize| column(&inverse, c).get(row).copied().unwrap_or(0.0);
            (0..GLOBALS).map(|c| of(c, a) * of(c, b)).sum()
        };
        for a in 0..GLOBALS {
            for b in 0..GLOBALS {
                let product: f64 = (0..GLOBALS).map(|c| covariance(a, c) * information(c, b)).sum();
                assert!((product - f64::from(u8::from(a == b))).abs() < 1e-9);
            }
        }
    }
}
