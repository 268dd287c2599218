//! Scratch memory of the averaging, cut into Gaussians: of all variables, and of those that are left once the shared
//! groups are marginalised.

use crate::estimator::{
    gaussian::triangle,
    widths::{LEFT_AFTER, SHARED, VARIABLES},
};

/// Gaussians in the filter's scratch memory, which is free between its updates.
pub(super) struct Levels<'a, T> {
    /// All variables at the widths that the filter runs with.
    pub base: Slices<'a, T>,
    /// Gaussian once the shared groups are marginalised at their present widths: the sets that share these start from
    /// it.
    pub after_first: Slices<'a, T>,
    /// Copy from which a set of widths marginalises its groups.
    pub work: Slices<'a, T>,
}

/// Mean and packed covariance of the first variables.
pub(super) struct Slices<'a, T> {
    pub mean: &'a mut [T],
    pub covariance: &'a mut [T],
}

impl<'a, T: Copy> Levels<'a, T> {
    /// Cuts the scratch memory up; `None` where it is too small.
    pub fn cut(scratch: &'a mut [T]) -> Option<Self> {
        let mut rest = scratch;
        let base = Slices::cut(&mut rest, VARIABLES)?;
        let after_first = Slices::cut(&mut rest, LEFT_AFTER[SHARED - 1])?;
        Some(Levels { base, after_first, work: Slices::cut(&mut rest, VARIABLES)? })
    }
}

impl<'a, T: Copy> Slices<'a, T> {
    /// Cuts so many variables off the memory; `None` where it is too small.
    pub fn cut(rest: &mut &'a mut [T], variables: usize) -> Option<Self> {
        let (mean, next) = core::mem::take(rest).split_at_mut_checked(variables)?;
        let (covariance, next) = next.split_at_mut_checked(triangle(variables))?;
        *rest = next;
        Some(Slices { mean, covariance })
    }

    /// Copies the variables that both Gaussians have.
    pub fn take(&mut self, mean: &[T], covariance: &[T]) {
        copy(self.mean, mean);
        copy(self.covariance, covariance);
    }
}

/// Copies as much as there is room for.
pub(super) fn copy<T: Copy>(to: &mut [T], from: &[T]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

#[cfg(test)]
mod tests;
