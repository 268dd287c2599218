//! The widths of the nuisances' priors over which the posterior is averaged.

#![allow(clippy::indexing_slicing)] // Constant tables.

use super::columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, BIAS, Group, HARD_IRON, MAG_LAG, MAG_SHAPE, MAG_TURN, P};

/// Groups whose width is averaged over: magnetometer shape, hard iron, accelerometer matrix, magnetometer misalignment,
/// accelerometer bias.
pub(super) const GROUPS: usize = 5;

/// Widths of each group - magnetometer shape, hard iron, accelerometer matrix, magnetometer misalignment, accelerometer
/// bias - as parts of the one that the filter runs with; the data sheets' first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// Widths of each group, as parts of the filter's.
    pub parts: [[f32; 3]; GROUPS],
    /// Number of widths of each group.
    pub count: [usize; GROUPS],
    /// Inflations of the covariance.
    pub inflations: [f32; 3],
    /// Number of inflations.
    pub inflation_count: usize,
    /// The data sheet's width of each group, as a part of the filter's.
    pub sheet: [f32; GROUPS],
    /// True if the lags of magnetometer and accelerometer are as well known as the rest of these sensors, and
    /// narrowed with it.
    pub with_lags: bool,
}

impl Widths {
    pub(super) const UNSET: Self = Self {
        parts: [[0.0; 3]; GROUPS],
        count: [0; GROUPS],
        inflations: [0.0; 3],
        inflation_count: 0,
        sheet: [0.0; GROUPS],
        with_lags: false,
    };

    /// Widths by hand. The data sheets' widths are 3 % for the magnetometer's shape and misalignment, 10 % of the field
    /// for the hard iron, 0.5 % for the accelerometer's matrix; the filter runs with 10 %, 30 % and 2 %. Averaged over
    /// are once, a third and thrice the data sheet's; for the accelerometer's matrix once, 0.3 and four times. The
    /// accelerometer's bias has one width, as its matrix holds the bias too.
    pub const HAND: Self = Self {
        parts: [[0.3, 0.09, 0.9], [1.0 / 3.0, 0.1, 1.0], [0.25, 0.075, 1.0], [0.3, 0.09, 0.9], [1.0; 3]],
        count: [3, 3, 3, 3, 1],
        // In slow motion the formal covariance is 2 to 6 times too small. Of the multiples of these inflations that
        // `cargo mwd bench --only benefit` tries, these are the smallest with which the estimator alone harms none of
        // thirteen recordings as they are.
        inflations: [0.7, 1.4, 2.8],
        inflation_count: 3,
        sheet: [0.3, 1.0 / 3.0, 0.25, 0.3, 1.0],
        with_lags: false,
    };

    /// Widths in a drill string: the data sheet's, a twentieth, and 0.3 % of it, less than which f32 does not tell from
    /// nothing. In steady rotation errors as wide as the data sheets' equal the third column of P, and a sensor that is
    /// better has to show it. The formal covariance is honest (0 to 70 deg, 30 to 180 rpm).
    ///
    /// The accelerometer's bias and the magnetometer's misalignment have widths of their own: in a vertical hole either
    /// may be what turns one vector against the tool axis, and its sensor's other errors must not decide its width.
    pub const DRILL_STRING: Self = Self {
        parts: [[1.0, 0.05, 0.003]; GROUPS],
        count: [3; GROUPS],
        inflations: [1.0; 3],
        inflation_count: 1,
        sheet: [1.0; GROUPS],
        with_lags: true,
    };
}

#[cfg(feature = "explanation")]
impl Widths {
    /// The grid with one set of widths alone.
    pub(super) fn only(&self, set: [usize; GROUPS]) -> Self {
        let mut one = Self { count: [1; GROUPS], ..*self };
        for ((one, all), index) in one.parts.iter_mut().zip(&self.parts).zip(set) {
            one[0] = all.get(index).copied().unwrap_or(1.0);
        }
        one
    }

    /// True for each group whose width in a set is the data sheet's.
    pub(super) fn sheets(&self, set: [usize; GROUPS]) -> [bool; GROUPS] {
        let is_sheet = |group: usize| {
            let width = self.parts.get(group).zip(set.get(group)).and_then(|(parts, index)| parts.get(*index));
            width == self.sheet.get(group)
        };
        core::array::from_fn(is_sheet)
    }
}

/// Widths of all groups, as indices into [`Widths::parts`], in the order in which the groups are marginalised.
pub(super) type Set = [u8; GROUPS];

impl Widths {
    /// A set of widths and all that differ from it in one group, one after the other; `None` beyond the last. First
    /// come those that differ in the group that is marginalised last: they share the work for all before it.
    pub(super) fn near(&self, centre: &Set, index: usize) -> Option<Set> {
        let mut set = *centre;
        let Some(mut rest) = index.checked_sub(1) else { return Some(set) };
        for (width, group) in set.iter_mut().rev().zip(TAKEN.into_iter().rev()) {
            let count = self.count.get(group).copied().unwrap_or(1);
            let others = count.saturating_sub(1);
            if rest < others {
                *width = (usize::from(*width) + 1 + rest).checked_rem(count).unwrap_or(0) as u8;
                return Some(set);
            }
            rest -= others;
        }
        None
    }
}

/// Returns true if two sets of widths differ in one group at most.
pub(super) fn are_near(a: &Set, b: &Set) -> bool {
    a.iter().zip(b).filter(|(a, b)| a != b).count() <= 1
}

/// Groups in the order in which they are marginalised, the largest first.
pub(super) const TAKEN: [usize; GROUPS] = [2, 0, 4, 3, 1];
/// Number of groups, the first in that order, that are marginalised once for all successive sets with the same widths.
pub(super) const SHARED: usize = 2;
/// Number of variables in the averaged covariance: P and bias first, then group by group, each group's lag behind it,
/// to be marginalised from the end.
pub(super) const VARIABLES: usize = LEFT_AFTER[0] + COUNTS[TAKEN[0]];
/// Number of variables of each group.
pub(super) const COUNTS: [usize; GROUPS] = [
    MAG_SHAPE.count + MAG_LAG.count,
    HARD_IRON.count,
    ACCEL_MATRIX.count + ACCEL_LAG.count,
    MAG_TURN.count,
    ACCEL_BIAS.count,
];
/// Number of variables that are left after each group, in the order in which they are marginalised.
pub(super) const LEFT_AFTER: [usize; GROUPS] = {
    let (mut left, mut k) = ([12; GROUPS], GROUPS - 1);
    while k > 0 {
        left[k - 1] = left[k] + COUNTS[TAKEN[k]];
        k -= 1;
    }
    left
};
/// True for groups with a lag, which is their last variable.
pub(super) const HAS_LAG: [bool; GROUPS] = [true, false, true, false, false];

/// Groups of columns in the order of the variables.
const ORDER: [Group; 9] = [P, BIAS, HARD_IRON, MAG_TURN, ACCEL_BIAS, MAG_SHAPE, MAG_LAG, ACCEL_MATRIX, ACCEL_LAG];

/// The column of a variable.
pub(super) const fn column(variable: usize) -> usize {
    let (mut index, mut before) = (0, 0);
    while index < ORDER.len() {
        let count = ORDER[index].count;
        if variable < before + count {
            return ORDER[index].from + variable - before;
        }
        before += count;
        index += 1;
    }
    0
}

#[cfg(test)]
mod tests;
