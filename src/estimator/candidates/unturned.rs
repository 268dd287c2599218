//! Errors of the magnetometer that look like another field of the earth while an axis of the body has not turned: hard
//! iron along the axis; and, of a tool that turns about its own axis alone, a magnetometer that reads more along it and
//! less across. Only a declared field tells them.

use super::{
    column_id::{ColumnId, Columns},
    entered::Posterior,
    matrix::{Beside, Matrix, savage_dickey},
};
use crate::{
    compensation::effect::MAX_PARAMETERS,
    estimator::{
        columns::{ALONG, HARD_IRON, MAG_SHAPE},
        real::Real,
    },
};
use heapless::Vec;

/// Dispersion from which on the data say nothing of a claim. A larger one may be infinite, and that, times a component
/// of zero, is no number.
const NOTHING: f32 = 1e8;

/// Columns of the hard iron, and of the magnetometer's shape.
const IRON: Columns = Columns::of_group(&HARD_IRON);
const SHAPE: Columns = Columns::of_group(&MAG_SHAPE);

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
    /// Evidence of a candidate with this iron among its parameters. `whole`: its evidence as stated; the rest of it
    /// counts at its own dispersion.
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
    fn columns(&self) -> impl Iterator<Item = ColumnId> {
        IRON.iter().zip(self.axes).filter(|(_, is_unturned)| *is_unturned).map(|(column, _)| column)
    }

    /// Columns of which nothing tells without a declared field: hard iron along the axes and, if the tool's own has not
    /// turned, the magnetometer's shape along it.
    pub fn hidden(&self) -> impl Iterator<Item = ColumnId> {
        let [.., along_the_tool] = self.axes;
        self.columns().chain(SHAPE.iter().skip(ALONG).take(usize::from(along_the_tool)))
    }

    /// Dispersion of a column's posterior variance, in units of the prior's: its information over what the declared
    /// field tells. What is beyond that is noise of the attitudes at which rows are made linear. At least `own`, and at
    /// least 1, because the declared field's deviations do not follow from the data's.
    fn dispersion(&self, column: ColumnId, variance: f32, own: f32) -> f32 {
        let told = IRON.place_of(column).and_then(|axis| self.told?.get(axis).copied());
        let least = if own > 1.0 { own } else { 1.0 };
        let ratio = told.map_or(least, |told| (1.0 / variance - 1.0) / told);
        if ratio < least {
            least
        } else if ratio < NOTHING {
            ratio
        } else {
            // A NaN is not below it either.
            NOTHING
        }
    }

    /// The columns of `fresh` that only a declared field tells of, alone beside the `done` ones; `None` without any.
    pub(super) fn beside<T: Real>(
        &self,
        matrix: &Matrix<T>,
        fresh: &[ColumnId],
        done: usize,
        own: f32,
    ) -> Option<IronAlone> {
        self.told?;
        let columns: Vec<ColumnId, 3> = self.columns().filter(|column| fresh.contains(column)).collect();
        if columns.is_empty() {
            return None;
        }
        let beside = Beside::new(matrix, &columns, done)?;
        let dispersions = columns.iter().enumerate();
        let dispersion = dispersions.fold(own, |most, (k, column)| self.dispersion(*column, beside.variance(k), most));
        Some(IronAlone { evidence: beside.evidence(None)?, dispersion })
    }

    /// The same of the posterior of a claim of these columns.
    pub(super) fn among<T: Real>(&self, posterior: &Posterior<T>, columns: Columns, own: f32) -> Option<IronAlone> {
        self.told?;
        let mut part =
            Posterior { mean: [T::ZERO; MAX_PARAMETERS], covariance: [[T::ZERO; MAX_PARAMETERS]; MAX_PARAMETERS] };
        let places: Vec<(ColumnId, usize), 3> =
            self.columns().filter_map(|column| Some((column, columns.place_of(column)?))).collect();
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
        columns: Columns,
        alone: Option<IronAlone>,
        own: f32,
    ) -> [T; MAX_PARAMETERS] {
        let mut dispersions = [T::of(own); MAX_PARAMETERS];
        if let Some(alone) = alone {
            for place in self.columns().filter_map(|column| columns.place_of(column)) {
                if let Some(slot) = dispersions.get_mut(place) {
                    *slot = T::of(alone.dispersion);
                }
            }
        }
        dispersions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimator::candidates::size::averaged;

    /// An iron of one prior width on each axis, which the data state to a hundredth, along axes of which the last has
    /// not turned.
    fn sized(told: f32) -> ([f32; 3], [f32; 3]) {
        let mut posterior =
            Posterior { mean: [0.0; MAX_PARAMETERS], covariance: [[0.0; MAX_PARAMETERS]; MAX_PARAMETERS] };
        for k in 0..3 {
            posterior.mean[k] = 1.0;
            posterior.covariance[k][k] = 1e-4;
        }
        let unturned = Unturned::new([false, false, true], Some([told; 3]));
        let columns = IRON;
        let alone = unturned.among(&posterior, columns, 1.0);
        assert!(alone.is_some_and(|alone| alone.evidence.is_finite() && alone.evidence / alone.dispersion >= 0.0));
        let of = averaged::<f32>(&posterior, 3, &unturned.dispersions(columns, alone, 1.0));
        let three = |of: &dyn Fn(usize) -> f32| [of(0), of(1), of(2)];
        (three(&|k| of.mean[k]), three(&|k| libm::sqrtf(of.covariance[k][k])))
    }

    #[test]
    fn iron_along_an_axis_that_has_not_turned_is_as_certain_as_the_declared_field_and_the_rest_as_the_data() {
        // Ten deviations: the other axes show that iron may be that large, so the prior hardly draws it.
        let (mean, sigma) = sized(100.0);
        assert!((sigma[2] - 0.1).abs() < 0.01 && (mean[2] - 1.0).abs() < 0.03, "{mean:?} {sigma:?}");
        assert!(sigma[..2].iter().all(|sigma| (sigma - 0.01).abs() < 0.001), "{sigma:?}");
    }

    #[test]
    fn where_the_declared_field_tells_nothing_the_prior_stays() {
        for told in [0.0, 1e-30, f32::NAN] {
            let (mean, sigma) = sized(told);
            assert!(mean.iter().chain(&sigma).all(|x| x.is_finite()), "{told}: {mean:?} {sigma:?}");
            assert!(mean[2].abs() < 0.01 && sigma[2] > 0.5, "{told}: {mean:?} {sigma:?}");
        }
    }
}
