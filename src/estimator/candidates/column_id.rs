//! Columns of the matrix in which effects are weighed: nuisances first, in the order of the table, then the effects'
//! own columns. The matrix lacks the table's last columns, bias and P, so that an index beyond the nuisances means
//! something else in each.

use crate::{
    compensation::VectorError,
    estimator::columns::{
        ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, Group, HARD_IRON, MAG_LAG, MAG_MATRIX, MAG_TURN, NUISANCES,
    },
};

/// One unknown of the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimator) struct ColumnId(u8);

impl ColumnId {
    /// Column of an effect, by its place among the effects' columns.
    #[cfg(test)]
    pub const fn of_effect(place: usize) -> Self {
        Self((NUISANCES + place) as u8)
    }

    /// Place in the matrix.
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Place among the effects' columns; `None` for a nuisance.
    pub const fn place(self) -> Option<usize> {
        self.index().checked_sub(NUISANCES)
    }
}

/// Columns side by side: those of one candidate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimator) struct Columns {
    from: u8,
    to: u8,
}

impl Columns {
    pub const NONE: Self = Self { from: 0, to: 0 };
    /// All nuisances.
    pub const NUISANCES: Self = Self { from: 0, to: NUISANCES as u8 };

    /// Columns of a group of nuisances.
    pub const fn of_group(group: &Group) -> Self {
        Self { from: group.from as u8, to: (group.from + group.count) as u8 }
    }

    /// Columns of the magnetometer's matrix and of the hard iron: the table's first.
    pub const fn of_magnetometer() -> Self {
        Self { from: MAG_MATRIX.from as u8, to: (HARD_IRON.from + HARD_IRON.count) as u8 }
    }

    /// Columns of an error of a vector sensor.
    pub const fn of_error(error: VectorError) -> Self {
        match error {
            VectorError::MagMatrix => Self::of_group(&MAG_MATRIX),
            VectorError::MagTurn => Self::of_group(&MAG_TURN),
            VectorError::HardIron => Self::of_group(&HARD_IRON),
            VectorError::AxialIron => Self { from: HARD_IRON.from as u8 + 2, ..Self::of_group(&HARD_IRON) },
            VectorError::MagLag => Self::of_group(&MAG_LAG),
            VectorError::AccelLag => Self::of_group(&ACCEL_LAG),
            VectorError::AccelMatrix => Self::of_group(&ACCEL_MATRIX),
            VectorError::AccelBias => Self::of_group(&ACCEL_BIAS),
        }
    }

    /// Columns of an effect, by the place of the first among the effects' columns.
    pub const fn of_effect(place: usize, count: usize) -> Self {
        let from = (NUISANCES + place) as u8;
        Self { from, to: from + count as u8 }
    }

    pub const fn len(self) -> usize {
        self.to.saturating_sub(self.from) as usize
    }

    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    pub fn iter(self) -> impl Iterator<Item = ColumnId> + Clone {
        (self.from..self.to).map(ColumnId)
    }

    pub fn has(self, column: ColumnId) -> bool {
        (self.from..self.to).contains(&column.0)
    }

    pub const fn are_within(self, others: Self) -> bool {
        others.from <= self.from && self.to <= others.to
    }

    pub const fn are_nuisances(self) -> bool {
        (self.from as usize) < NUISANCES
    }

    /// Splits off the first column.
    pub const fn next(&mut self) -> Option<ColumnId> {
        if self.is_empty() {
            return None;
        }
        let first = ColumnId(self.from);
        self.from += 1;
        Some(first)
    }
}

#[cfg(test)]
mod tests;
