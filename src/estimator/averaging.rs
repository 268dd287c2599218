//! Average of P and b over the unknown scales of the other errors: the widths of the other sensors' priors, an
//! inflation of the covariance, and the scale of P's own prior, each weighed by its evidence. The mean flies: a
//! direction that the data say nothing about stays at the factory's.
//!
//! From the root's inverse (`inverse_root`) comes the covariance; group by group the other sensors' variables are
//! taken out of it (`levels`), for each of their widths; what is left of P and b is averaged over the inflations and
//! the scales along P's eigenvectors (`directions`) and added up (`mixture`).

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
    widths::{COUNTS, GROUPS, HAS_LAG, LEFT_AFTER, LEFT_AFTER_TWO, TAKEN, VARIABLES, Widths, column},
};
use core::ops::Range;
use levels::{Levels, Slices, copy};
use mixture::Sum;

/// P and b.
const GYRO: usize = 12;
/// P.
const NINE: usize = 9;
/// Work units, as those of `crate::estimator::work`, of one set of widths: where all change, and where the last two do.
const WIDTHS_UNITS: [u32; 2] = [650, 520];

/// Mean and covariance in units of the prior's widths, P row-major and then b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Averaged<T> {
    pub mean: [T; GYRO],
    /// Packed, lower triangle.
    pub covariance: [T; triangle(GYRO)],
    /// Directions of P that the data decide, at the most likely widths.
    pub decided: u8,
    /// Variances at these widths with P's prior as wide as it was begun with, at no smaller scale.
    pub unscaled_variance: [T; GYRO],
    /// Geometric mean of the widths, over the data sheets'.
    pub widths: [T; GROUPS],
}

/// Piece of the averaging in progress.
#[derive(Clone, Copy)]
pub(super) struct Averaging<T> {
    stage: usize,
    grid: Widths,
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
        Self { stage: 0, grid: Widths::UNSET, evidence: [T::ZERO; GROUPS], sum: Sum::zero() }
    }

    /// Begins: `scratch` takes mean and covariance, and until that is gathered the inverse of the root.
    pub fn start(&mut self, globals: &Globals<T>, widths: &Widths, scratch: &mut [[T; WIDTH]]) {
        self.stage = 0;
        self.grid = *widths;
        self.sum = Sum::zero();
        let scratch = scratch.as_flattened_mut();
        // At the end, where it is in nobody's way; column c has c + 1 elements.
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

    /// Adds some columns of the inverse to the covariance; `false` when all are in.
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

    /// Adds what is not known of the effects that are taken out, when all else is averaged: the covariance grows by the
    /// outer product of this vector, in the globals' order. The mean is that of P and b beside the effects as they are
    /// taken out. Drawn to the factory's because of what an effect may be, P would go without the effect, and the two
    /// of them together would not fit the data.
    pub fn spread(&mut self, by: &[T; GLOBALS]) {
        self.sum.spread(&core::array::from_fn(|i| by.get(column(i)).copied().unwrap_or(T::ZERO)));
    }

    /// Work units of the next set of widths: more where the first group changes its own.
    pub fn units(&self) -> u32 {
        let [all, two] = WIDTHS_UNITS;
        if self.is_first_new() { all } else { two }
    }

    /// Returns true if the group that is taken out first has another width than in the set before.
    fn is_first_new(&self) -> bool {
        let of = |stage: usize| self.grid.set(stage).map(|[first, ..]| first);
        self.stage == 0 || of(self.stage) != of(self.stage - 1)
    }

    /// One set of widths; `false` when all are done. `scratch` must be left alone from one to the next.
    pub fn step(&mut self, scratch: &mut [[T; WIDTH]]) -> bool {
        let Some(chosen) = self.grid.set(self.stage) else { return false };
        let Some(mut levels) = Levels::cut(scratch.as_flattened_mut()) else { return false };
        let is_first_new = self.is_first_new();
        // By group.
        let mut parts = [1.0; GROUPS];
        for (group, index) in TAKEN.into_iter().zip(chosen) {
            let width = self.grid.parts.get(group).and_then(|widths| widths.get(index));
            if let (Some(part), Some(width)) = (parts.get_mut(group), width) {
                *part = *width;
            }
        }
        let with_lags = self.grid.with_lags;
        let mut take_out = |level: usize, work: &mut Slices<T>, variables: usize| {
            let group = TAKEN.get(level).copied().unwrap_or(0);
            let width = parts.get(group).map_or(T::ONE, |part| T::of(*part));
            let evidence = narrowed(work, variables, group, width, with_lags);
            if let Some(slot) = self.evidence.get_mut(level) {
                *slot = evidence;
            }
        };
        let Levels { base, after_first, work } = &mut levels;
        if is_first_new {
            work.take(base.mean, base.covariance);
            take_out(0, work, VARIABLES);
            after_first.take(work.mean, work.covariance);
        }
        work.take(after_first.mean, after_first.covariance);
        take_out(1, work, LEFT_AFTER);
        take_out(2, work, LEFT_AFTER_TWO);
        let mut widths = [T::ZERO; GROUPS];
        for ((width, part), sheet) in widths.iter_mut().zip(parts).zip(self.grid.sheet) {
            *width = T::of(part / sheet).logarithm();
        }
        let evidence = self.evidence.iter().fold(T::ZERO, |sum, x| sum + *x);
        let mut of = Gaussian { mean: [T::ZERO; GYRO], covariance: [T::ZERO; triangle(GYRO)] };
        copy(&mut of.mean, work.mean);
        copy(&mut of.covariance, work.covariance);
        let inflations = self.grid.inflations.get(..self.grid.inflation_count).unwrap_or_default();
        self.sum.add(&of, inflations, evidence, widths);
        self.stage += 1;
        true
    }

    /// Returns true if nothing has been averaged yet.
    #[cfg(feature = "explanation")]
    pub const fn is_fresh(&self) -> bool {
        self.stage == 0
    }

    /// Logarithm of the evidence of all that was averaged, but for a constant of the grid's size.
    #[cfg(feature = "explanation")]
    pub fn log_evidence(&self) -> T {
        self.sum.log_evidence()
    }

    /// The average; over the scales of the bias, too, where no rest has measured it.
    pub fn result(&self, is_bias_measured: bool) -> Averaged<T> {
        let mut averaged = self.sum.averaged();
        if !is_bias_measured {
            bias_scale::average(&mut averaged);
        }
        averaged
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

/// Narrows the priors of a group, the last of the variables, and takes these out of the mean and covariance that stay;
/// the logarithm of the evidence.
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
