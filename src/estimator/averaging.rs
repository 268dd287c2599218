//! Average of P and b over the unknown scales of the other errors: the widths of the other sensors' priors, an
//! inflation of the covariance, and the scale of P's own prior, each weighed by its evidence. The mean flies: a
//! direction that the data say nothing about stays at the factory's.
//!
//! From the root's inverse (`inverse_root`) comes the covariance; group by group the other sensors' variables are
//! taken out of it (`levels`), for each of their widths; what is left of P and b is averaged over the inflations and
//! the scales along P's eigenvectors (`directions`) and added up (`mixture`).
//!
//! Only the sets of widths near the likeliest of the 243 are evaluated: that set and all that differ from it in one
//! group. If one of these is likelier, the sets near it follow. The next average begins where this one ends.

#![allow(clippy::indexing_slicing)] // Constant indices into threes.

mod bias_scale;
mod directions;
mod inverse_root;
mod levels;
mod mixture;

use super::{
    columns::GLOBALS,
    gaussian::{narrow_last, narrow_two, triangle},
    globals::Globals,
    real::Real,
    rows::WIDTH,
    unrolled::add_two_times,
    widths::{COUNTS, GROUPS, HAS_LAG, LEFT_AFTER, SHARED, Set, TAKEN, VARIABLES, Widths, are_near, column},
};
use core::ops::Range;
use levels::{Levels, Slices, copy};
use mixture::Sum;

/// Number of elements of P and b.
const GYRO: usize = 12;
/// Number of elements of P.
const NINE: usize = 9;
/// Units of work, as [`Probe::poll`](crate::Probe::poll) counts them, of one set of widths: if the shared groups
/// change too, and if not.
const WIDTHS_UNITS: [u32; 2] = [650, 520];

/// Mean and covariance in units of the prior's widths, P row-major and then b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Averaged<T> {
    pub mean: [T; GYRO],
    /// Packed, lower triangle.
    pub covariance: [T; triangle(GYRO)],
    /// Directions of P that the data decide, at the most likely widths.
    pub decided: u8,
    /// Variances of P and b at these widths, with P's prior as wide as configured (scale 1).
    pub unscaled_variance: [T; GYRO],
    /// Geometric mean of each group's width, over the data sheet's.
    pub widths: [T; GROUPS],
}

/// Most centres in one average: sets of widths whose neighbours are evaluated, one centre after the other.
const CENTRES: usize = 4;

/// State of the averaging, which is done in pieces.
#[derive(Clone, Copy)]
pub(super) struct Averaging<T> {
    grid: Widths,
    /// Centres so far, the latest last, and their number.
    centres: [Set; CENTRES],
    count: usize,
    /// Index of the latest centre's next neighbour.
    next: usize,
    /// Log evidence of the likeliest set so far, and that set.
    best: (T, Set),
    /// Widths at which the shared groups are marginalised in the scratch memory; `None` before any.
    held: Option<[u8; SHARED]>,
    evidence: [T; GROUPS],
    sum: Sum<T>,
}

/// P and b at one set of widths.
struct Gaussian<T> {
    mean: [T; GYRO],
    /// Packed, lower triangle.
    covariance: [T; triangle(GYRO)],
}

impl<T: Real> Averaging<T> {
    pub const fn zero() -> Self {
        Self {
            grid: Widths::UNSET,
            centres: [[0; GROUPS]; CENTRES],
            count: 0,
            next: 0,
            best: (T::ZERO, [0; GROUPS]),
            held: None,
            evidence: [T::ZERO; GROUPS],
            sum: Sum::zero(),
        }
    }

    /// Begins an average: `scratch` holds mean and covariance and, until the covariance is gathered, the root's
    /// inverse.
    pub fn start(&mut self, globals: &Globals<T>, widths: &Widths, scratch: &mut [[T; WIDTH]]) {
        self.grid = *widths;
        self.centres[0] = self.best.1;
        (self.count, self.next, self.held) = (1, 0, None);
        self.sum = Sum::zero();
        let scratch = scratch.as_flattened_mut();
        // The inverse lies at the end, behind mean and covariance; its column c has c + 1 elements.
        let Some(place) = scratch.len().checked_sub(triangle(GLOBALS)) else { return };
        let (front, inverse) = scratch.split_at_mut(place);
        inverse_root::invert(&globals.root, inverse);
        let mut rest = front;
        let Some(base) = Slices::cut(&mut rest, VARIABLES) else { return };
        for (i, mean) in base.mean.iter_mut().enumerate() {
            *mean = globals.x.get(column(i)).copied().unwrap_or(T::ZERO);
        }
        base.covariance.fill(T::ZERO);
    }

    /// Adds some columns of the root's inverse to the covariance; returns `false` when all are in.
    pub fn gather(&self, columns: Range<usize>, scratch: &mut [[T; WIDTH]]) -> bool {
        let scratch = scratch.as_flattened_mut();
        let Some(place) = scratch.len().checked_sub(triangle(GLOBALS)) else { return false };
        let (mut rest, inverse) = scratch.split_at_mut(place);
        let Some(base) = Slices::cut(&mut rest, VARIABLES) else { return false };
        for c in columns.clone().step_by(2).filter(|c| *c < GLOBALS) {
            let by = |c: usize| -> [T; VARIABLES] {
                let own = inverse_root::column(inverse, c);
                core::array::from_fn(|i| own.get(column(i)).copied().unwrap_or(T::ZERO))
            };
            let second = if c + 1 < GLOBALS { by(c + 1) } else { [T::ZERO; VARIABLES] };
            add_outers(base.covariance, &[by(c), second]);
        }
        columns.end < GLOBALS
    }

    /// Adds the uncertainty of the effects that are taken out, once the average has ended: the covariance grows by the
    /// outer product of `by`, which is in the globals' order. The mean stays: it is that of P and b beside the effects
    /// as they are taken out. If the uncertainty of an effect drew P to the factory's, P and the effect would not fit
    /// the data together. P and b follow an effect as far as the other sensors' errors do not: `by` is narrowed to the
    /// likeliest widths as the mean is, which is linear. `scratch` is that of the average.
    pub fn inflate(&mut self, by: &[T; GLOBALS], scratch: &mut [[T; WIDTH]]) {
        let Some(Levels { base, mut work, .. }) = Levels::cut(scratch.as_flattened_mut()) else { return };
        work.take(base.mean, base.covariance);
        for (i, x) in work.mean.iter_mut().enumerate() {
            *x = by.get(column(i)).copied().unwrap_or(T::ZERO);
        }
        for place in 0..GROUPS {
            self.take_out(place, &self.best.1, &mut work);
        }
        self.sum.inflate(work.mean);
    }

    /// Group that is marginalised at a place in the order, and its width in a set.
    fn width(&self, place: usize, set: &Set) -> (usize, f32) {
        let group = TAKEN.get(place).copied().unwrap_or(0);
        let widths = self.grid.parts.get(group).zip(set.get(place));
        let width = widths.and_then(|(widths, index)| widths.get(usize::from(*index)));
        (group, width.copied().unwrap_or(1.0))
    }

    /// Marginalises the group of a place at its width in a set; returns the log evidence.
    #[inline(never)]
    fn take_out(&self, place: usize, set: &Set, work: &mut Slices<T>) -> T {
        let (group, width) = self.width(place, set);
        let variables = place.checked_sub(1).and_then(|before| LEFT_AFTER.get(before)).copied().unwrap_or(VARIABLES);
        narrowed(work, variables, group, T::of(width), self.grid.with_lags)
    }

    /// Work units of the next set of widths: more if it changes the widths of the shared groups.
    pub fn units(&self) -> u32 {
        let [all, rest] = WIDTHS_UNITS;
        let is_held = self.following().is_some_and(|(_, next)| self.held.is_some_and(|held| next.starts_with(&held)));
        if is_held { rest } else { all }
    }

    /// Next neighbour of the latest centre that is no neighbour of an earlier one, with its index.
    fn following(&self) -> Option<(usize, Set)> {
        let centres = self.centres.get(..self.count)?;
        let (latest, earlier) = centres.split_last()?;
        let mut near = (self.next..).map_while(|index| Some((index, self.grid.near(latest, index)?)));
        near.find(|(_, set)| !earlier.iter().any(|centre| are_near(set, centre)))
    }

    /// Next set of widths. If the latest centre has no neighbour left and one of them was likelier, that one is the
    /// next centre.
    fn advance(&mut self) -> Option<Set> {
        loop {
            if let Some((index, set)) = self.following() {
                self.next = index + 1;
                return Some(set);
            }
            let is_latest = self.count.checked_sub(1).and_then(|last| self.centres.get(last)) == Some(&self.best.1);
            let slot = self.centres.get_mut(self.count).filter(|_| !is_latest)?;
            *slot = self.best.1;
            (self.count, self.next) = (self.count + 1, 0);
        }
    }

    /// Evaluates one set of widths; returns `false` when all are done. `scratch` must not change between the calls.
    pub fn step(&mut self, scratch: &mut [[T; WIDTH]]) -> bool {
        let is_first = self.is_fresh();
        let Some(chosen) = self.advance() else { return false };
        let Some(mut levels) = Levels::cut(scratch.as_flattened_mut()) else { return false };
        let Levels { base, after_first, work } = &mut levels;
        let held = chosen.first_chunk().copied();
        let first = if self.held == held { SHARED } else { 0 };
        if first == 0 {
            self.held = held;
            work.take(base.mean, base.covariance);
        }
        let mut widths = [T::ZERO; GROUPS];
        for place in 0..GROUPS {
            if place == SHARED {
                if first == 0 {
                    after_first.take(work.mean, work.covariance);
                }
                work.take(after_first.mean, after_first.covariance);
            }
            if place >= first {
                let evidence = self.take_out(place, &chosen, work);
                if let Some(slot) = self.evidence.get_mut(place) {
                    *slot = evidence;
                }
            }
            let (group, part) = self.width(place, &chosen);
            if let (Some(width), Some(sheet)) = (widths.get_mut(group), self.grid.sheet.get(group)) {
                *width = T::of(part / sheet).logarithm();
            }
        }
        let evidence = self.evidence.iter().fold(T::ZERO, |sum, x| sum + *x);
        let mut of = Gaussian { mean: [T::ZERO; GYRO], covariance: [T::ZERO; triangle(GYRO)] };
        copy(&mut of.mean, work.mean);
        copy(&mut of.covariance, work.covariance);
        let inflations = self.grid.inflations.get(..self.grid.inflation_count).unwrap_or_default();
        let log = self.sum.add(&of, inflations, evidence, widths);
        if is_first || log > self.best.0 {
            self.best = (log, chosen);
        }
        true
    }

    /// Returns true if nothing has been averaged yet.
    pub const fn is_fresh(&self) -> bool {
        self.count == 1 && self.next == 0
    }

    /// Log evidence of all sets that were averaged, but for a constant of the grid's size.
    #[cfg(feature = "explanation")]
    pub fn log_evidence(&self) -> T {
        self.sum.log_evidence()
    }

    /// Ends the average, once all sets are in. If no rest has measured the bias, it is also over the scales of the
    /// bias's prior.
    pub fn finish(&mut self, is_bias_measured: bool) {
        self.sum.finish();
        if !is_bias_measured {
            bias_scale::average(&mut self.sum.of);
        }
    }

    /// The average, once it has ended.
    pub const fn result(&self) -> &Averaged<T> {
        &self.sum.of
    }
}

/// Adds the outer products of two vectors to a packed triangle.
fn add_outers<T: Real>(covariance: &mut [T], [a, b]: &[[T; VARIABLES]; 2]) {
    let mut rest = covariance;
    for (i, (x, y)) in a.iter().zip(b).enumerate() {
        let Some((row, next)) = core::mem::take(&mut rest).split_at_mut_checked(i + 1) else { return };
        if *x != T::ZERO || *y != T::ZERO {
            add_two_times(row, [*x, *y], [a, b]);
        }
        rest = next;
    }
}

/// Narrows the priors of a group, whose variables are the last, and marginalises these out of mean and covariance;
/// returns the log evidence.
fn narrowed<T: Real>(all: &mut Slices<T>, variables: usize, group: usize, width: T, with_lags: bool) -> T {
    let mut evidence = T::ZERO;
    let (Some(count), Some(has_lag)) = (COUNTS.get(group), HAS_LAG.get(group)) else { return evidence };
    let mut left = *count;
    while left > 0 {
        let n = variables - count + left;
        let last = if left == *count && *has_lag && !with_lags { T::ONE } else { width };
        let (Some(mean), Some(covariance)) = (all.mean.get_mut(..n), all.covariance.get_mut(..triangle(n))) else {
            break;
        };
        if left == 1 {
            evidence += narrow_last(mean, covariance, last);
            break;
        }
        let [first, second] = narrow_two(mean, covariance, [last, width]);
        evidence = evidence + first + second;
        left -= 2;
    }
    evidence
}

#[cfg(test)]
mod tests;
