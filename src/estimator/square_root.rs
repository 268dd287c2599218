//! Triangular roots of information by Householder reflections. Normal equations are never formed: in f32 they lose
//! their positive definiteness in three of four recordings.

use super::real::Real;

/// Reflects column `column` of `pivot` and `rows` into the pivot; all from `column` on are changed. Rows that are
/// zero there are left alone. A pivot without any part in the column stays as it is.
pub(super) fn reflect<T: Real, const W: usize>(pivot: &mut [T; W], rows: &mut [[T; W]], column: usize) {
    reflect_behind(pivot, rows, column, 0);
}

/// The same where the rows have `skip` columns before those of the pivot.
pub(super) fn reflect_behind<T: Real, const W: usize, const L: usize>(
    pivot: &mut [T; W],
    rows: &mut [[T; L]],
    column: usize,
    skip: usize,
) {
    reflect_with(pivot, rows, column, skip, Further::<T, 0> { pivot: &mut [], rows: &mut [], columns: 0 });
}

/// Further columns of the pivot and of the rows, and how many of them are in use.
pub(super) struct Further<'a, T, const E: usize> {
    pub pivot: &'a mut [T; E],
    pub rows: &'a mut [[T; E]],
    pub columns: usize,
}

/// The same with further columns, which take part and are never eliminated here.
pub(super) fn reflect_with<T: Real, const W: usize, const L: usize, const E: usize>(
    pivot: &mut [T; W],
    rows: &mut [[T; L]],
    column: usize,
    skip: usize,
    further: Further<T, E>,
) {
    let of = |row: &[T; L]| row.get(skip + column).copied().unwrap_or(T::ZERO);
    let below = rows.iter().fold(T::ZERO, |sum, row| sum + of(row) * of(row));
    if below == T::ZERO {
        return;
    }
    let Some((x, right)) = pivot.get_mut(column..).and_then(<[T]>::split_first_mut) else { return };
    let norm = (*x * *x + below).root();
    let alpha = if *x > T::ZERO { -norm } else { norm };
    let v = *x - alpha;
    let beta = T::ONE / (alpha * v);
    *x = alpha;
    let mut dots = [T::ZERO; E];
    let (dots, _) = dots.split_at_mut(if further.columns < E { further.columns } else { E });
    for (dot, x) in dots.iter_mut().zip(further.pivot.iter()) {
        *dot = v * *x;
    }
    for (row, further) in rows.iter().zip(further.rows.iter()) {
        let factor = of(row);
        if factor != T::ZERO {
            for (dot, x) in dots.iter_mut().zip(further) {
                *dot += factor * *x;
            }
        }
    }
    for (dot, x) in dots.iter_mut().zip(further.pivot.iter_mut()) {
        *dot *= beta;
        *x += v * *dot;
    }
    for (row, further) in rows.iter().zip(further.rows.iter_mut()) {
        let factor = of(row);
        if factor != T::ZERO {
            for (dot, x) in dots.iter().zip(further) {
                *x += factor * *dot;
            }
        }
    }
    let mut dots = [T::ZERO; W];
    for (dot, x) in dots.iter_mut().zip(right.iter()) {
        *dot = v * *x;
    }
    for row in rows.iter() {
        let factor = of(row);
        if factor != T::ZERO {
            for (dot, x) in dots.iter_mut().zip(row.iter().skip(skip + column + 1)) {
                *dot += factor * *x;
            }
        }
    }
    for (dot, x) in dots.iter_mut().zip(right.iter_mut()) {
        *dot *= beta;
        *x += v * *dot;
    }
    for row in rows.iter_mut() {
        let factor = of(row);
        if factor != T::ZERO {
            for (dot, x) in dots.iter().zip(row.iter_mut().skip(skip + column + 1)) {
                *x += factor * *dot;
            }
            if let Some(x) = row.get_mut(skip + column) {
                *x = T::ZERO;
            }
        }
    }
}

/// The same where pivot and rows stand in one slice, the pivot first.
pub(super) fn reflect_first<T: Real, const W: usize>(rows: &mut [[T; W]], column: usize) {
    if let Some((pivot, rest)) = rows.split_first_mut() {
        reflect(pivot, rest, column);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::indexing_slicing, clippy::needless_range_loop)]
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro128PlusPlus;

    #[test]
    fn the_root_has_the_information_of_the_rows_and_what_is_left_the_residual() {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(5);
        let mut rows = [[0.0_f64; 5]; 9];
        for value in rows.as_flattened_mut() {
            *value = f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.4;
        }
        rows[3] = [0.0; 5];
        let product = |rows: &[[f64; 5]], i: usize, j: usize| rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
        let before: [[f64; 5]; 5] = core::array::from_fn(|i| core::array::from_fn(|j| product(&rows, i, j)));
        for column in 0..4 {
            reflect_first(&mut rows[column..], column);
        }
        for i in 0..5 {
            for j in 0..5 {
                assert!((product(&rows, i, j) - before[i][j]).abs() < 1e-12);
            }
            for row in rows.iter().skip(i + 1).filter(|_| i < 4) {
                assert!(row[i].abs() < 1e-15);
            }
        }
    }
}
