//! The widths of the nuisances' priors over which the posterior is averaged.

#![allow(clippy::indexing_slicing)] // Constant tables.

use super::columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, BIAS, Group, HARD_IRON, MAG_LAG, MAG_MATRIX, P};

/// Groups whose width is averaged over: magnetometer matrix, hard iron, accelerometer.
pub(super) const GROUPS: usize = 3;

/// Widths of each group - magnetometer matrix, hard iron, accelerometer - as parts of the one that the filter runs
/// with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// The widths.
    pub parts: [[f32; 3]; GROUPS],
    /// Number of widths of each group.
    pub count: [usize; GROUPS],
    /// Inflations of the covariance.
    pub inflations: [f32; 3],
    /// Number of inflations.
    pub inflation_count: usize,
    /// The data sheet's.
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

    /// By hand: a third, once and thrice the data sheets' 3 %, 10 % of the norm and 0.5 % (that: 0.3, 1, 4), of 10 %,
    /// 30 % and 2 %.
    pub const HAND: Self = Self {
        parts: [[0.09, 0.3, 0.9], [0.1, 1.0 / 3.0, 1.0], [0.075, 0.25, 1.0]],
        count: [3, 3, 3],
        // Where motion is slow the formal covariance is 2 to 6 times too small. Multiplied by 1.4, 0.7 and 0.36, these
        // fly 0.74, 0.80 and 0.87 of the gain that is to be had on thirteen recordings with a gyro error of 2 %; the
        // last one harms one of them as it is. So these stay 2.8 times above it.
        inflations: [0.7, 1.4, 2.8],
        inflation_count: 3,
        sheet: [0.3, 1.0 / 3.0, 0.25],
        with_lags: false,
    };

    /// In a drill string: from the data sheets' to next to nothing, which is a third of a percent of it: less, f32
    /// does not tell apart. In steady rotation the data sheets' widths equal the third column of P, and a sensor that
    /// is better has to show it. The formal covariance is honest (0 to 70 deg, 30 to 180 rpm).
    pub const DRILL_STRING: Self = Self {
        parts: [[0.003, 0.05, 1.0]; GROUPS],
        count: [3; GROUPS],
        inflations: [1.0; 3],
        inflation_count: 1,
        sheet: [1.0; GROUPS],
        with_lags: true,
    };
}

#[cfg(feature = "explanation")]
impl Widths {
    /// The grid of one set of widths alone.
    pub(super) fn only(&self, set: [usize; GROUPS]) -> Self {
        let mut one = Self { count: [1; GROUPS], ..*self };
        for ((one, all), index) in one.parts.iter_mut().zip(&self.parts).zip(set) {
            one[0] = all.get(index).copied().unwrap_or(1.0);
        }
        one
    }

    /// Which widths of a set are the data sheet's.
    pub(super) fn sheets(&self, set: [usize; GROUPS]) -> [bool; GROUPS] {
        let is_sheet = |group: usize| {
            let width = self.parts.get(group).zip(set.get(group)).and_then(|(parts, index)| parts.get(*index));
            width == self.sheet.get(group)
        };
        core::array::from_fn(is_sheet)
    }
}

impl Widths {
    /// Widths of a set, one of each group in the order in which they are taken out. Any two widths of different groups
    /// are together in one set, and of three each nine of the 27 sets do for that (an orthogonal array: Rao 1947); the
    /// data sheets' are one of them. `None` beyond the last.
    pub(super) fn set(&self, index: usize) -> Option<[usize; GROUPS]> {
        let [first, second, third] = TAKEN.map(|group| self.count[group]);
        let (a, b) = (index.checked_div(second)?, index.checked_rem(second)?);
        let c = (third - (a + b).checked_rem(third)?).checked_rem(third)?;
        (a < first).then_some([a, b, c])
    }
}

/// Groups in the order in which they are taken out, the largest first: it is taken out once for each of its widths, the
/// others for every set.
pub(super) const TAKEN: [usize; GROUPS] = [2, 0, 1];
/// Variables whose covariance is looked at: P and bias first, then group by group, each group's lag behind it, to be
/// taken out from the end.
pub(super) const VARIABLES: usize = 12 + COUNTS[2] + COUNTS[1] + COUNTS[0];
/// Variables of a group.
pub(super) const COUNTS: [usize; GROUPS] =
    [MAG_MATRIX.count + MAG_LAG.count, HARD_IRON.count, ACCEL_MATRIX.count + ACCEL_BIAS.count + ACCEL_LAG.count];
/// Variables that are left after the group that is taken out first, and after the next.
pub(super) const LEFT_AFTER: usize = LEFT_AFTER_TWO + COUNTS[TAKEN[1]];
pub(super) const LEFT_AFTER_TWO: usize = 12 + COUNTS[TAKEN[2]];
/// Groups with a lag, which is their last variable.
pub(super) const HAS_LAG: [bool; GROUPS] = [true, false, true];

/// The groups of columns in that order.
const ORDER: [Group; 8] = [P, BIAS, HARD_IRON, MAG_MATRIX, MAG_LAG, ACCEL_MATRIX, ACCEL_BIAS, ACCEL_LAG];

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
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn any_two_widths_meet_once_and_the_data_sheets_are_a_set() {
        for grid in [Widths::HAND, Widths::DRILL_STRING] {
            let sets: Vec<[usize; GROUPS]> = (0..).map_while(|index| grid.set(index)).collect();
            assert_eq!(sets.len(), 9);
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let mut pairs: Vec<_> = sets.iter().map(|set| (set[i], set[j])).collect();
                pairs.sort_unstable();
                pairs.dedup();
                assert_eq!(pairs.len(), 9);
            }
            let is_sheet = |set: &[usize; GROUPS]| {
                TAKEN.iter().zip(set).all(|(group, index)| grid.parts[*group][*index] == grid.sheet[*group])
            };
            assert!(sets.iter().any(is_sheet));
        }
    }

    #[test]
    fn every_variable_is_another_column() {
        let mut columns: Vec<usize> = (0..VARIABLES).map(column).collect();
        columns.sort_unstable();
        columns.dedup();
        assert_eq!(columns.len(), VARIABLES);
        assert_eq!([column(0), column(11), column(VARIABLES - 1)], [28, 27, 12]);
    }
}
