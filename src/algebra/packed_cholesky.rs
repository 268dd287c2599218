//! Cholesky factors of packed symmetric positive-definite matrices N = L L^T: lower triangles row by row with inverted
//! diagonals. One copy of the code serves every size.

/// Factorises a matrix in place, given as the rows of its lower triangle. `None` if it is not finite or not
/// positive definite to f32's precision.
#[inline(never)]
pub(crate) fn factorise(elements: &mut [f32]) -> Option<()> {
    let (mut i, mut start) = (0, 0);
    while start < elements.len() {
        // Rows lie one after the other, so that the sums run along slices.
        let (above, below) = elements.split_at_mut_checked(start)?;
        let row = below.get_mut(..=i)?;
        let mut rest = above as &[f32];
        for j in 0..=i {
            let (done, open) = row.split_at_mut_checked(j)?;
            let element = open.first_mut()?;
            if i == j {
                let sum = *element - done.iter().fold(0.0, |sum, x| sum + x * x);
                // A pivot that loses all but the last few bits of its diagonal is rounding noise (f32: 2^-24
                // each of D terms).
                let floor = *element * 1e-6;
                if !(sum > floor && sum.is_finite()) {
                    return None;
                }
                *element = 1.0 / libm::sqrtf(sum);
            } else {
                let (other, next) = rest.split_at_checked(j + 1)?;
                let (inverse, factors) = other.split_last()?;
                let sum = *element - done.iter().zip(factors).fold(0.0, |sum, (x, y)| sum + x * y);
                *element = sum * inverse;
                rest = next;
            }
        }
        i += 1;
        start += i;
    }
    Some(())
}

/// Solves L y = rhs in place, for as many rows as `y` has.
#[inline(never)]
pub(crate) fn solve_lower(mut rows: &[f32], y: &mut [f32]) {
    for i in 0..y.len() {
        let Some((row, next)) = rows.split_at_checked(i + 1) else { return };
        let (done, open) = y.split_at_mut_checked(i).unwrap_or_default();
        if let (Some(value), Some((inverse, factors))) = (open.first_mut(), row.split_last()) {
            *value = factors.iter().zip(done).fold(*value, |sum, (l, y)| sum - l * *y) * inverse;
        }
        rows = next;
    }
}

/// Solves L^T x = rhs in place, for as many rows as `x` has.
#[inline(never)]
pub(crate) fn solve_upper(elements: &[f32], x: &mut [f32]) {
    let mut size = x.len();
    let mut rows = elements.get(..size * (size + 1) / 2).unwrap_or_default();
    while let Some((above, row)) = rows.len().checked_sub(size).and_then(|start| rows.split_at_checked(start)) {
        let (Some((inverse, factors)), Some((value, others))) =
            (row.split_last(), x.get_mut(..size).and_then(|x| x.split_last_mut()))
        else {
            return;
        };
        *value *= inverse;
        // Subtract the known value's column from the others, along the row.
        for (x, l) in others.iter_mut().zip(factors) {
            *x -= l * *value;
        }
        rows = above;
        size -= 1;
    }
}
