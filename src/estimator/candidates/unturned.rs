//! Hard iron along axes of the body that have not turned: only a declared field tells it from the earth's.

use super::{
    entered::Posterior,
    matrix::{Beside, Matrix, savage_dickey},
};
use crate::{
    compensation::effect::MAX_PARAMETERS,
    estimator::{columns::HARD_IRON, real::Real},
};
use core::ops::Range;
use heapless::Vec;

/// Axes that have not turned, and what a declared field tells of a constant field along them.
pub(in crate::estimator) struct Unturned {
    axes: [bool; 3],
    /// Information of the declared field, in units of the prior's widths; `None` without one.
    told: Option<[f32; 3]>,
}

/// Evidence of iron along the axes that have not turned, alone, and its dispersion.
#[derive(Clone, Copy)]
pub(super) struct IronAlone {
    pub evidence: f32,
    pub dispersion: f32,
}

impl IronAlone {
    /// Evidence of a claim with this iron among its parameters, `whole` as stated, the rest of it at its own dispersion.
    pub fn of_whole(alone: Option<Self>, whole: f32, own: f32) -> f32 {
        alone.map_or(whole / own, |alone| alone.evidence / alone.dispersion + (whole - alone.evidence) / own)
    }
}

impl Unturned {
    /// No axis.
    pub const NONE: Self = Self { axes: [false; 3], told: None };

    pub const fn new(axes: [bool; 3], told: Option<[f32; 3]>) -> Self {
        Self { axes, told }
    }

    pub const fn is_told(&self) -> bool {
        self.told.is_some()
    }

    /// Hard-iron columns along the axes.
    pub fn columns(&self) -> impl Iterator<Item = usize> {
        HARD_IRON.columns().zip(self.axes).filter(|(_, is_unturned)| *is_unturned).map(|(column, _)| column)
    }

    /// Dispersion of a column's posterior variance, in units of the prior's: its information over what the declared
    /// field tells. What is beyond that is noise of the attitudes at which rows are made linear. At least `own`, and at
    /// least 1, because the declared field's deviations do not follow from the data's.
    fn dispersion(&self, column: usize, variance: f32, own: f32) -> f32 {
        let told = column.checked_sub(HARD_IRON.from).and_then(|axis| self.told?.get(axis).copied());
        let least = if own > 1.0 { own } else { 1.0 };
        let ratio = told.map_or(least, |told| (1.0 / variance - 1.0) / told);
        // A NaN is not above it either.
        if ratio > least { ratio } else { least }
    }

    /// The columns of `fresh` that only a declared field tells of, alone beside the `done` ones; `None` without any.
    pub(super) fn beside<T: Real>(&self, matrix: &Matrix<T>, fresh: &[u8], done: usize, own: f32) -> Option<IronAlone> {
        self.told?;
        let is_of = |column: &usize| fresh.iter().any(|fresh| usize::from(*fresh) == *column);
        let columns: Vec<u8, 3> = self.columns().filter(is_of).map(|column| column as u8).collect();
        if columns.is_empty() {
            return None;
        }
        let beside = Beside::new(matrix, &columns, done)?;
        let dispersions = columns.iter().enumerate();
        let dispersion =
            dispersions.fold(own, |most, (k, column)| self.dispersion(usize::from(*column), beside.variance(k), most));
        Some(IronAlone { evidence: beside.evidence(None)?, dispersion })
    }

    /// The same of the posterior of a claim of these columns.
    pub(super) fn among<T: Real>(
        &self,
        posterior: &Posterior<T>,
        columns: &Range<usize>,
        own: f32,
    ) -> Option<IronAlone> {
        self.told?;
        let mut part =
            Posterior { mean: [T::ZERO; MAX_PARAMETERS], covariance: [[T::ZERO; MAX_PARAMETERS]; MAX_PARAMETERS] };
        let places: Vec<(usize, usize), 3> = self
            .columns()
            .filter(|column| columns.contains(column))
            .map(|column| (column, column - columns.start))
            .collect();
        let mut dispersion = own;
        for (k, (column, place)) in places.iter().enumerate() {
            let (row, mean) = (posterior.covariance.get(*place)?, posterior.mean.get(*place)?);
            *part.mean.get_mut(k)? = *mean;
            for (slot, (_, other)) in part.covariance.get_mut(k)?.iter_mut().zip(&places) {
                *slot = *row.get(*other)?;
            }
            dispersion = self.dispersion(*column, row.get(*place)?.narrow(), dispersion);
        }
        let n = places.len();
        (n > 0).then(|| IronAlone { evidence: savage_dickey(&part.mean, &part.covariance, n).narrow(), dispersion })
    }

    /// Dispersions of a claim's parameters: that of the iron alone along the axes, its own of the others.
    pub(super) fn dispersions<T: Real>(
        &self,
        columns: &Range<usize>,
        alone: Option<IronAlone>,
        own: f32,
    ) -> [T; MAX_PARAMETERS] {
        let mut dispersions = [T::of(own); MAX_PARAMETERS];
        if let Some(alone) = alone {
            for column in self.columns().filter(|column| columns.contains(column)) {
                if let Some(slot) = dispersions.get_mut(column - columns.start) {
                    *slot = T::of(alone.dispersion);
                }
            }
        }
        dispersions
    }
}
