//! Population search of a window's cost (paper, section 3): IMOA, or one of the searches it is compared with, from
//! the posterior's mean. It is done in slices and adds no accuracy on sound recordings; docs/identification.md, step
//! 8.

#[cfg(feature = "baseline-searches")]
mod baseline;

use crate::{
    config::OptimizerKind,
    estimator::{WINDOW_NODES, WindowCost},
    optimizer::{Cost, Found, Imoa, ImoaSettings, LevenbergMarquardt, Optimizer, Progress, SearchSpace},
};
#[cfg(feature = "baseline-searches")]
use baseline::Baseline;

/// Members of a population: IMOA's moves alone did best with 12 on simulated windows; with its exchange 1 to 12 do
/// equally well.
const POPULATION: usize = 12;

/// Half width of the search box in posterior deviations: the posterior's mean is within a few of the optimum.
pub const RADIUS: f32 = 10.0;

/// Window's cost as a population searches it: the box [-1, 1]^12 reaches [`RADIUS`] posterior deviations in each
/// whitened coordinate.
pub struct Searched<'b, 'a, const NODES: usize = WINDOW_NODES>(pub &'b WindowCost<'a, NODES>);

impl<const NODES: usize> Cost<12> for Searched<'_, '_, NODES> {
    /// Not inlined, so that the chip has one copy for all optimisers.
    #[inline(never)]
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        self.0.evaluate(&y.map(|y| RADIUS * y))
    }
}

/// Search in progress; only one takes memory. Each begins at the posterior's mean.
#[expect(
    clippy::large_enum_variant,
    reason = "the memory of the largest is there for all, and nothing here can be boxed"
)]
// `None` is all zeros.
#[repr(u32)]
pub(super) enum Search {
    /// No search: the posterior's mean stands.
    None,
    Imoa(Imoa<12, POPULATION>),
    Lm(LevenbergMarquardt<12, 78>),
    #[cfg(feature = "baseline-searches")]
    Baseline(Baseline),
}

impl Search {
    pub fn new(kind: OptimizerKind, most: u32, seed: u64) -> Self {
        match kind {
            // The unit box and the default settings are valid; without a search the posterior's mean stands.
            OptimizerKind::Imoa => {
                Imoa::new(&SearchSpace::UNIT, ImoaSettings::new(most), seed).map_or(Self::None, Self::Imoa)
            }
            OptimizerKind::Lm => Self::Lm(LevenbergMarquardt::new([0.0; 12], most)),
            #[cfg(feature = "baseline-searches")]
            kind => Baseline::new(kind, most, seed).map_or(Self::None, Self::Baseline),
            // `Config::validate` refuses a configuration that names another search.
            #[cfg(not(feature = "baseline-searches"))]
            _ => Self::None,
        }
    }

    pub fn step<const NODES: usize>(&mut self, window: &WindowCost<'_, NODES>) -> Progress {
        match self {
            Self::None => Progress::Done,
            Self::Imoa(search) => search.step(&Searched(window)),
            Self::Lm(search) => search.step(window),
            #[cfg(feature = "baseline-searches")]
            Self::Baseline(search) => search.step(&Searched(window)),
        }
    }

    /// Returns the best point found, in posterior deviations, and its cost; `None` without a search.
    pub fn best(&self) -> Option<([f32; 12], f32)> {
        let (y, cost) = match self {
            Self::None => return None,
            Self::Lm(search) => {
                let (y, cost) = search.best();
                return Some((*y, cost));
            }
            Self::Imoa(search) => search.best(),
            #[cfg(feature = "baseline-searches")]
            Self::Baseline(search) => search.best(),
        };
        Some((y.map(|y| RADIUS * y), cost))
    }

    pub fn evaluations(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Imoa(search) => search.evaluations(),
            Self::Lm(search) => search.evaluations(),
            #[cfg(feature = "baseline-searches")]
            Self::Baseline(search) => search.evaluations(),
        }
    }
}
