//! The widths of the nuisances' priors over which the posterior is averaged.

use super::columns::{ACCEL_BIAS, ACCEL_MATRIX, HARD_IRON, MAG_MATRIX};

/// Groups whose width is averaged over: magnetometer matrix, hard iron, accelerometer.
pub(super) const GROUPS: usize = 3;

/// Widths of each group - magnetometer matrix, hard iron, accelerometer - as parts of the one that the filter runs with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// The widths.
    pub parts: [[f32; 4]; GROUPS],
    /// How many of them.
    pub count: [usize; GROUPS],
    /// The data sheet's.
    pub sheet: [f32; GROUPS],
}

impl Widths {
    pub(super) const UNSET: Self = Self { parts: [[0.0; 4]; GROUPS], count: [0; GROUPS], sheet: [0.0; GROUPS] };

    /// By hand: a third, once and thrice the data sheets' 3 %, 10 % of the norm and 0.5 % (that: 0.3, 1, 4), of 10 %, 30 % and 2 %.
    pub const HAND: Self = Self {
        parts: [[0.09, 0.3, 0.9, 1.0], [0.1, 1.0 / 3.0, 1.0, 1.0], [0.075, 0.25, 1.0, 1.0]],
        count: [3, 3, 3],
        sheet: [0.3, 1.0 / 3.0, 0.25],
    };
}

/// The order of the variables whose covariance is looked at: bias and P first, then group by group, to be taken out from the end.
pub(super) const VARIABLES: usize = 9 + 3 + ACCEL + HARD_IRON.count + MAG_MATRIX.count;
/// Matrix and bias of the accelerometer.
pub(super) const ACCEL: usize = ACCEL_MATRIX.count + ACCEL_BIAS.count;
/// Variables that are left after each group.
pub(super) const LEFT_AFTER: [usize; GROUPS] = [12 + ACCEL + HARD_IRON.count, 12 + ACCEL, 12];

/// The column of a variable.
pub(super) const fn column(variable: usize) -> usize {
    match variable {
        0..9 => super::columns::P.from + variable,
        9..12 => super::columns::BIAS.from + variable - 9,
        _ => {
            let after = variable - 12;
            if after < ACCEL {
                ACCEL_MATRIX.from + after
            } else if after < ACCEL + HARD_IRON.count {
                HARD_IRON.from + after - ACCEL
            } else {
                MAG_MATRIX.from + after - ACCEL - HARD_IRON.count
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    extern crate std;
    use std::vec::Vec;

    #[test]
    fn every_variable_is_another_column() {
        let mut columns: Vec<usize> = (0..VARIABLES).map(column).collect();
        columns.sort_unstable();
        columns.dedup();
        assert_eq!(columns.len(), VARIABLES);
        assert_eq!([column(0), column(11), column(VARIABLES - 1)], [28, 27, 7]);
    }
}
