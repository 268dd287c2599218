#[cfg(feature = "baseline-searches")]
mod baseline;

use super::WindowCost;
use crate::{
    config::OptimizerKind,
    optimizer::{Found, Imoa, ImoaSettings, LevenbergMarquardt, Optimizer, Progress, SearchSpace},
};
#[cfg(feature = "baseline-searches")]
use baseline::Baseline;

/// Members of a population: IMOA's moves alone did best with 12 on simulated windows; with its exchange 1 to 12 do equally well.
const POPULATION: usize = 12;

/// Half width of the search box in posterior deviations: the least-squares point is within a few of the optimum.
const RADIUS: f32 = 10.0;

/// The search in progress, whichever it is: only one takes memory. Population searches work in whitened coordinates about the
/// least-squares point, Levenberg-Marquardt in parameters.
#[expect(
    clippy::large_enum_variant,
    reason = "the memory of the largest is there for all, and nothing here can be boxed"
)]
// None is all zeros.
#[repr(u32)]
pub(super) enum Search {
    /// The least-squares point stands.
    None,
    Imoa(Imoa<12, POPULATION>),
    Lm(LevenbergMarquardt<12, 78>),
    #[cfg(feature = "baseline-searches")]
    Baseline(Baseline),
}

impl Search {
    pub fn new(kind: OptimizerKind, most: u32, seed: u64) -> Self {
        match kind {
            // The unit box and the default settings are valid; without a search the least-squares point stands.
            OptimizerKind::Imoa => {
                Imoa::new(&SearchSpace::UNIT, ImoaSettings::new(most), seed).map_or(Self::None, Self::Imoa)
            }
            OptimizerKind::Lm => Self::Lm(LevenbergMarquardt::new([0.0; 12], most)),
            #[cfg(feature = "baseline-searches")]
            kind => Baseline::new(kind, most, seed).map_or(Self::None, Self::Baseline),
            // A configuration that names another is refused.
            #[cfg(not(feature = "baseline-searches"))]
            _ => Self::None,
        }
    }

    pub fn step(&mut self, window: &WindowCost) -> Progress {
        match self {
            Self::None => Progress::Done,
            Self::Imoa(search) => search.step(&window.whitened(RADIUS)),
            Self::Lm(search) => search.step(window),
            #[cfg(feature = "baseline-searches")]
            Self::Baseline(search) => search.step(&window.whitened(RADIUS)),
        }
    }

    /// The best point found, as a change of theta.
    pub fn best(&self, window: &WindowCost) -> [f32; 12] {
        let y = match self {
            Self::None => return [0.0; 12],
            Self::Lm(search) => return *search.best().0,
            Self::Imoa(search) => search.best().0,
            #[cfg(feature = "baseline-searches")]
            Self::Baseline(search) => search.best(),
        };
        window.change(&y.map(|y| RADIUS * y))
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
