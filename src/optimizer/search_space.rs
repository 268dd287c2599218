//! Search space of a cost.

#[cfg(any(test, feature = "baseline-searches"))]
use super::random::uniform;
#[cfg(any(test, feature = "baseline-searches"))]
use rand_xoshiro::Xoshiro128PlusPlus;

/// Search space: a box, a start in it and the width of the first population.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSpace<const D: usize> {
    lower: [f32; D],
    upper: [f32; D],
    start: [f32; D],
    /// Standard deviation of the first population about the start, in half widths of the box.
    deviation: f32,
}

/// Reason to refuse a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
pub enum OptimizerError {
    /// The cost has no variables.
    NoDimensions,
    /// A bound, the start or the width between the bounds is not finite.
    NotFinite {
        /// The variable.
        dimension: usize,
    },
    /// The lower bound is not below the upper.
    BoundsReversed {
        /// The variable.
        dimension: usize,
    },
    /// The start is outside its bounds.
    StartOutside {
        /// The variable.
        dimension: usize,
    },
    /// The first population's deviation is not positive and finite.
    Deviation,
    /// The method needs more members.
    PopulationTooSmall {
        /// Least number of members.
        needed: usize,
    },
    /// A setting of the method is not finite or out of its range.
    Setting(&'static str),
}

impl core::fmt::Display for OptimizerError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoDimensions => write!(f, "a search needs at least one variable"),
            Self::NotFinite { dimension } => write!(f, "variable {dimension}: bounds and start must be finite"),
            Self::BoundsReversed { dimension } => {
                write!(f, "variable {dimension}: the lower bound must be below the upper")
            }
            Self::StartOutside { dimension } => write!(f, "variable {dimension}: the start must be within the bounds"),
            Self::Deviation => write!(f, "the first population's deviation must be positive and finite"),
            Self::PopulationTooSmall { needed } => write!(f, "the population must have at least {needed} members"),
            Self::Setting(name) => write!(f, "the setting {name} is out of its range"),
        }
    }
}

impl core::error::Error for OptimizerError {}

impl<const D: usize> SearchSpace<D> {
    /// Unit box [-1, 1]^D about a start at 0: whitened coordinates. Deviation 0.1.
    pub const UNIT: Self = Self { lower: [-1.0; D], upper: [1.0; D], start: [0.0; D], deviation: 0.1 };

    /// Creates a box without a known start: its centre, with a deviation of 0.6 half widths (eq 9: mean 0.5
    /// and deviation 0.3 of the whole width).
    ///
    /// # Errors
    /// Rejects bounds that are reversed, equal or not finite.
    pub fn within(lower: [f32; D], upper: [f32; D]) -> Result<Self, OptimizerError> {
        let mut start = lower;
        for (x, u) in start.iter_mut().zip(&upper) {
            // Halves first: the sum of two large bounds is infinite.
            *x = 0.5 * *x + 0.5 * u;
        }
        Self::about(start, 0.6, lower, upper)
    }

    /// Creates a box about a known start; `deviation` is in half widths of the box.
    ///
    /// # Errors
    /// Rejects bounds that are reversed, equal or not finite, a start outside them, and a deviation that is
    /// not positive.
    pub fn about(start: [f32; D], deviation: f32, lower: [f32; D], upper: [f32; D]) -> Result<Self, OptimizerError> {
        let space = Self { lower, upper, start, deviation };
        space.check()?;
        Ok(space)
    }

    pub(super) fn check(&self) -> Result<(), OptimizerError> {
        if D == 0 {
            return Err(OptimizerError::NoDimensions);
        }
        for (dimension, ((l, u), s)) in self.lower.iter().zip(&self.upper).zip(&self.start).enumerate() {
            if !(l.is_finite() && u.is_finite() && s.is_finite() && (u - l).is_finite()) {
                return Err(OptimizerError::NotFinite { dimension });
            }
            if l >= u {
                return Err(OptimizerError::BoundsReversed { dimension });
            }
            if s < l || s > u {
                return Err(OptimizerError::StartOutside { dimension });
            }
        }
        let positive = self.deviation.is_finite() && self.deviation > 0.0;
        if positive { Ok(()) } else { Err(OptimizerError::Deviation) }
    }

    /// Start of the search: the first point that is evaluated.
    #[must_use]
    pub const fn start(&self) -> &[f32; D] {
        &self.start
    }

    /// Standard deviation of the first population about the start, in half widths of the box.
    #[must_use]
    pub const fn deviation(&self) -> f32 {
        self.deviation
    }

    /// Lower and upper bound of each variable.
    pub(super) fn bounds(&self) -> impl Iterator<Item = (f32, f32)> {
        self.lower.iter().copied().zip(self.upper.iter().copied())
    }

    pub(super) fn half_widths(&self) -> impl Iterator<Item = f32> {
        self.bounds().map(|(l, u)| 0.5 * (u - l))
    }

    /// Moves variables outside the box to its wall.
    // Not inlined: one copy on the chip.
    #[inline(never)]
    pub(super) fn confine(&self, x: &mut [f32; D]) {
        for (x, (l, u)) in x.iter_mut().zip(self.bounds()) {
            // In this order a NaN goes to the wall too.
            *x = if *x > u {
                u
            } else if *x >= l {
                *x
            } else {
                l
            };
        }
    }

    /// Draws variables outside the box anew, uniformly.
    #[cfg(any(test, feature = "baseline-searches"))]
    pub(super) fn redraw(&self, x: &mut [f32; D], generator: &mut Xoshiro128PlusPlus) {
        for (x, (l, u)) in x.iter_mut().zip(self.bounds()) {
            if !(*x >= l && *x <= u) {
                *x = l + uniform(generator) * (u - l);
            }
        }
    }
}

#[cfg(test)]
mod tests;
