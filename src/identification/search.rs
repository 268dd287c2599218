use super::WindowCost;
use crate::{
    config::OptimizerKind,
    optimizer::{
        DifferentialEvolution, DifferentialEvolutionSettings, Found, Imoa, ImoaLiteral, ImoaLiteralSettings,
        ImoaSettings, LevenbergMarquardt, Moa, MoaSettings, Optimizer, Progress, Pso, PsoSettings, RandomSearch,
        SearchSpace,
    },
};

/// Members of a population: IMOA's moves alone did best with 12 on simulated windows; with its exchange 1 to 12 do equally well.
const POPULATION: usize = 12;

/// Members of differential evolution: with 12 it stands still before it is there (11 of 20 seeds at 500 evaluations, 14 at 1,000, against
/// 13 and 20). The published advice, 60 and more, is not for this memory.
const DE_POPULATION: usize = 24;

/// Half width of the search box in posterior deviations: the least-squares point is within a few of the optimum.
const RADIUS: f32 = 10.0;

/// The search in progress, whichever it is: only one takes memory. Population searches work in whitened coordinates about the
/// least-squares point, Levenberg-Marquardt in parameters.
#[expect(
    clippy::large_enum_variant,
    reason = "the memory of the largest is there for all, and nothing here can be boxed"
)]
pub(super) enum Search {
    /// The least-squares point stands.
    None,
    Imoa(Imoa<12, POPULATION>),
    ImoaLiteral(ImoaLiteral<12, POPULATION>),
    Moa(Moa<12, POPULATION>),
    Pso(Pso<12, POPULATION>),
    De(DifferentialEvolution<12, DE_POPULATION>),
    Random(RandomSearch<12>),
    Lm(LevenbergMarquardt<12, 78>),
}

impl Search {
    pub fn new(kind: OptimizerKind, most: u32, seed: u64) -> Self {
        let space = &SearchSpace::UNIT;
        let made = match kind {
            OptimizerKind::Imoa => Imoa::new(space, ImoaSettings::new(most), seed).map(Self::Imoa),
            OptimizerKind::ImoaLiteral => {
                ImoaLiteral::new(space, ImoaLiteralSettings::new(most), seed).map(Self::ImoaLiteral)
            }
            OptimizerKind::Moa => Moa::new(space, MoaSettings::new(most), seed).map(Self::Moa),
            OptimizerKind::Pso => Pso::new(space, PsoSettings::new(most), seed).map(Self::Pso),
            OptimizerKind::De => {
                DifferentialEvolution::new(space, DifferentialEvolutionSettings::new(most), seed).map(Self::De)
            }
            OptimizerKind::Random => RandomSearch::new(space, most, seed).map(Self::Random),
            OptimizerKind::Lm => Ok(Self::Lm(LevenbergMarquardt::new([0.0; 12], most))),
            OptimizerKind::Ls => Ok(Self::None),
        };
        // The unit box and the default settings are valid; without a search the least-squares point stands.
        made.unwrap_or(Self::None)
    }

    pub fn step(&mut self, window: &WindowCost) -> Progress {
        let cost = &window.whitened(RADIUS);
        match self {
            Self::None => Progress::Done,
            Self::Imoa(search) => search.step(cost),
            Self::ImoaLiteral(search) => search.step(cost),
            Self::Moa(search) => search.step(cost),
            Self::Pso(search) => search.step(cost),
            Self::De(search) => search.step(cost),
            Self::Random(search) => search.step(cost),
            Self::Lm(search) => search.step(window),
        }
    }

    /// The best point found, as a change of theta.
    pub fn best(&self, window: &WindowCost) -> [f32; 12] {
        let y = match self {
            Self::None => return [0.0; 12],
            Self::Lm(search) => return *search.best().0,
            Self::Imoa(search) => search.best().0,
            Self::ImoaLiteral(search) => search.best().0,
            Self::Moa(search) => search.best().0,
            Self::Pso(search) => search.best().0,
            Self::De(search) => search.best().0,
            Self::Random(search) => search.best().0,
        };
        window.change(&y.map(|y| RADIUS * y))
    }

    pub fn evaluations(&self) -> u32 {
        match self {
            Self::None => 0,
            Self::Imoa(search) => search.evaluations(),
            Self::ImoaLiteral(search) => search.evaluations(),
            Self::Moa(search) => search.evaluations(),
            Self::Pso(search) => search.evaluations(),
            Self::De(search) => search.evaluations(),
            Self::Random(search) => search.evaluations(),
            Self::Lm(search) => search.evaluations(),
        }
    }
}
