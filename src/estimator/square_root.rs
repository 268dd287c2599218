//! Triangular roots of information by Householder reflections. Normal equations are never formed: in f32 they lose
//! their positive definiteness in three of four recordings.
//!
//! Rows go into a pivot by blocks of a fixed number, column by column: the factors of the reflection, and the block's
//! part of the column, then stay in registers. Two reflections at a time halve the loads and stores. What a Cortex-M4F
//! can do at best is two instructions a multiply-add, its product and its sum. A desk's processor takes several columns
//! at a time, each in the same order, so that it has the same bits.

#![allow(clippy::indexing_slicing)] // Columns: each is compared with the row's length before.

use super::real::Real;

/// Rows of the first block: with two reflections they take 27 of 32 registers.
const BLOCK: usize = 9;
/// Rows of the blocks after it: rows come in threes, one for each axis.
const AXES: usize = 3;
/// Columns that are reflected together: two vector registers of a desk's processor.
const TOGETHER: usize = if cfg!(target_os = "none") { 1 } else { 8 };

/// Reflection of a pivot and a block of rows that leaves zeros in one column of the rows.
#[derive(Clone, Copy)]
pub(super) struct Reflection<T, const M: usize> {
    /// Factor of each row; the pivot's is 1.
    factors: [T; M],
    scale: T,
}

impl<T: Real, const M: usize> Reflection<T, M> {
    /// Reflection that changes nothing.
    pub const NOTHING: Self = Self { factors: [T::ZERO; M], scale: T::ZERO };

    /// Takes the elements of a column into the pivot's; changes nothing where they are zero.
    pub fn new(pivot: &mut T, elements: &[T; M]) -> Self {
        let below = elements.iter().fold(T::ZERO, |sum, x| sum + *x * *x);
        if below == T::ZERO {
            return Self::NOTHING;
        }
        let norm = (*pivot * *pivot + below).root();
        let alpha = if *pivot > T::ZERO { -norm } else { norm };
        let own = *pivot - alpha;
        let inverse = T::ONE / own;
        *pivot = alpha;
        Self { factors: elements.map(|x| x * inverse), scale: own / alpha }
    }

    /// Takes a column of a block into the pivot.
    fn eliminate<const L: usize>(pivot: &mut T, rows: &mut [[T; L]; M], column: usize) -> Self {
        let mut elements = [T::ZERO; M];
        for (x, row) in elements.iter_mut().zip(rows) {
            if let Some(element) = row.get_mut(column) {
                (*x, *element) = (*element, T::ZERO);
            }
        }
        Self::new(pivot, &elements)
    }

    fn is_nothing(&self) -> bool {
        self.scale == T::ZERO
    }

    /// Reflects another column.
    #[inline(always)]
    pub fn turn_one(&self, pivot: &mut T, column: &mut [T; M]) {
        let (elements, _) = column.as_chunks_mut::<1>();
        if let Some(elements) = elements.first_chunk_mut() {
            self.turn(core::array::from_mut(pivot), elements);
        }
    }

    /// Reflects other columns.
    #[inline(always)]
    fn turn<const W: usize>(&self, pivots: &mut [T; W], rows: &mut [[T; W]; M]) {
        let mut by = *pivots;
        for (f, row) in self.factors.iter().zip(&*rows) {
            by.iter_mut().zip(row).for_each(|(sum, x)| *sum += *f * *x);
        }
        for (pivot, by) in pivots.iter_mut().zip(&mut by) {
            *by = self.scale * *by;
            *pivot += *by;
        }
        for (f, row) in self.factors.iter().zip(rows) {
            row.iter_mut().zip(&by).for_each(|(x, by)| *x += *f * *by);
        }
    }

    /// Reflects the columns of a pivot, which the rows have from `from` on.
    #[inline(never)]
    fn sweep<const L: usize>(&self, pivot: &mut [T], rows: &mut [[T; L]; M], from: usize) {
        let (groups, single) = pivot.as_chunks_mut::<TOGETHER>();
        let mut column = from;
        for pivots in groups {
            let Some(mut elements) = elements(rows, column) else { return };
            self.turn(pivots, &mut elements);
            put(rows, column, &elements);
            column += TOGETHER;
        }
        for pivot in single {
            let Some(mut elements) = elements(rows, column) else { return };
            self.turn(core::array::from_mut(pivot), &mut elements);
            put(rows, column, &elements);
            column += 1;
        }
    }

    /// Reflects the columns of two pivots: into the first, then into the second.
    #[inline(never)]
    fn sweep_two<const L: usize>(both: &[Self; 2], pivots: (&mut [T], &mut [T]), rows: &mut [[T; L]; M], from: usize) {
        let [first, second] = both;
        let length = if pivots.0.len() < pivots.1.len() { pivots.0.len() } else { pivots.1.len() };
        let (groups, single) = pivots.0.split_at_mut(length).0.as_chunks_mut::<TOGETHER>();
        let (groups_of_two, single_of_two) = pivots.1.split_at_mut(length).0.as_chunks_mut::<TOGETHER>();
        let mut column = from;
        for (one, two) in groups.iter_mut().zip(groups_of_two) {
            let Some(mut elements) = elements(rows, column) else { return };
            first.turn(one, &mut elements);
            second.turn(two, &mut elements);
            put(rows, column, &elements);
            column += TOGETHER;
        }
        for (one, two) in single.iter_mut().zip(single_of_two) {
            let Some(mut elements) = elements(rows, column) else { return };
            first.turn(core::array::from_mut(one), &mut elements);
            second.turn(core::array::from_mut(two), &mut elements);
            put(rows, column, &elements);
            column += 1;
        }
    }
}

/// Elements of some columns of a block of rows; `None` beyond the rows' end.
#[inline(always)]
fn elements<T: Real, const L: usize, const M: usize, const W: usize>(
    rows: &[[T; L]; M],
    column: usize,
) -> Option<[[T; W]; M]> {
    if L < W || column > L - W {
        return None;
    }
    let mut elements = [[T::ZERO; W]; M];
    for (x, row) in elements.iter_mut().zip(rows) {
        x.copy_from_slice(&row[column..column + W]);
    }
    Some(elements)
}

/// Writes `W` columns of the rows, from `column` on; does nothing if they reach beyond the rows' last column.
#[inline(always)]
fn put<T: Real, const L: usize, const M: usize, const W: usize>(
    rows: &mut [[T; L]; M],
    column: usize,
    elements: &[[T; W]; M],
) {
    if L < W || column > L - W {
        return;
    }
    for (row, x) in rows.iter_mut().zip(elements) {
        row[column..column + W].copy_from_slice(x);
    }
}

/// Pivots that take rows block by block.
trait Pivots<T, const L: usize, const E: usize> {
    /// Takes a block of rows and their further columns.
    fn take<const M: usize>(&mut self, rows: &mut [[T; L]; M], further: &mut [[T; E]; M]);
}

/// A pivot from a column on, which the rows have at `at`, and its further columns, which they have from `from` on.
pub(super) struct Pivot<'a, T> {
    pub own: &'a mut [T],
    pub at: usize,
    pub further: &'a mut [T],
    pub from: usize,
}

impl<T: Real, const L: usize, const E: usize> Pivots<T, L, E> for Pivot<'_, T> {
    #[inline(always)]
    fn take<const M: usize>(&mut self, rows: &mut [[T; L]; M], further: &mut [[T; E]; M]) {
        let Some((pivot, own)) = self.own.split_first_mut() else { return };
        let reflection = Reflection::eliminate(pivot, rows, self.at);
        if !reflection.is_nothing() {
            reflection.sweep(own, rows, self.at + 1);
            reflection.sweep(self.further, further, self.from);
        }
    }
}

/// Two pivots, of which the second begins one column after the first.
struct Two<'a, T> {
    first: Pivot<'a, T>,
    second: Pivot<'a, T>,
}

impl<T: Real, const L: usize, const E: usize> Pivots<T, L, E> for Two<'_, T> {
    #[inline(always)]
    fn take<const M: usize>(&mut self, rows: &mut [[T; L]; M], further: &mut [[T; E]; M]) {
        let at = self.first.at;
        let ([a, next, first @ ..], [b, second @ ..]) = (&mut *self.first.own, &mut *self.second.own) else { return };
        let one = Reflection::eliminate(a, rows, at);
        if !one.is_nothing()
            && let Some(mut column) = elements(rows, at + 1)
        {
            one.turn(core::array::from_mut(next), &mut column);
            put(rows, at + 1, &column);
        }
        let two = Reflection::eliminate(b, rows, at + 1);
        if one.is_nothing() && two.is_nothing() {
            return;
        }
        let both = [one, two];
        Reflection::sweep_two(&both, (first, second), rows, at + 2);
        Reflection::sweep_two(&both, (self.first.further, self.second.further), further, self.first.from);
    }
}

/// Takes all rows: a block, then threes, then one by one.
fn take_all<T, const L: usize, const E: usize>(
    into: &mut impl Pivots<T, L, E>,
    rows: &mut [[T; L]],
    further: &mut [[T; E]],
) {
    let first = if rows.len() < BLOCK || further.len() < BLOCK { 0 } else { BLOCK };
    let (block, rows) = rows.split_at_mut(first);
    let (beside, further) = further.split_at_mut(first);
    if let (Some(block), Some(beside)) = (block.first_chunk_mut::<BLOCK>(), beside.first_chunk_mut::<BLOCK>()) {
        into.take(block, beside);
    }
    let (threes, rows) = rows.as_chunks_mut::<AXES>();
    let (threes_beside, further) = further.as_chunks_mut::<AXES>();
    for (block, beside) in threes.iter_mut().zip(threes_beside) {
        into.take(block, beside);
    }
    for (row, beside) in rows.iter_mut().zip(further) {
        into.take(core::array::from_mut(row), core::array::from_mut(beside));
    }
}

/// Takes a column of the rows into a pivot. Further columns take part and are not eliminated: there are as many rows of
/// them.
pub(super) fn reflect<T: Real, const L: usize, const E: usize>(
    mut pivot: Pivot<T>,
    rows: &mut [[T; L]],
    further: &mut [[T; E]],
) {
    take_all(&mut pivot, rows, further);
}

/// Takes two columns of the rows into two pivots, of which the second has nothing in the first column.
pub(super) fn reflect_two<T: Real, const L: usize, const E: usize>(
    [first, second]: [Pivot<T>; 2],
    rows: &mut [[T; L]],
    further: &mut [[T; E]],
) {
    take_all(&mut Two { first, second }, rows, further);
}

/// Takes a column of the rows below the first into the first row.
pub(super) fn reflect_first<T: Real, const L: usize>(rows: &mut [[T; L]], column: usize) {
    let Some((pivot, rest)) = rows.split_first_mut() else { return };
    let own = pivot.get_mut(column..).unwrap_or_default();
    let mut none = [[]; BLOCK + AXES];
    let none = none.get_mut(..rest.len()).unwrap_or_default();
    reflect(Pivot { own, at: column, further: &mut [], from: 0 }, rest, none);
}

#[cfg(test)]
mod tests;
