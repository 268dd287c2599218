//! Population searches of the library on double-precision costs, in whitened coordinates.

use meerkat_mwd::optimizer::{
    Cost, DifferentialEvolution, DifferentialEvolutionSettings, Imoa, ImoaSettings, Optimizer, OptimizerError, Pso,
    PsoSettings, SearchSpace,
};
use nalgebra::{Cholesky, Const};

use super::{
    effort::Spent,
    readings::{Matrix12, Theta},
};

/// A population search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Search {
    Imoa,
    Pso,
    DifferentialEvolution,
}

impl Search {
    pub const ALL: [Self; 3] = [Self::Imoa, Self::Pso, Self::DifferentialEvolution];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Imoa => "IMOA",
            Self::Pso => "PSO",
            Self::DifferentialEvolution => "DE",
        }
    }

    /// The best point of a box after `most` evaluations, with the populations that the library's own
    /// comparison uses.
    pub fn best<const D: usize>(
        self,
        cost: &dyn Cost<D>,
        space: &SearchSpace<D>,
        most: u32,
        seed: u64,
    ) -> Result<[f32; D], OptimizerError> {
        let mut search: Box<dyn Optimizer<dyn Cost<D> + '_, D>> = match self {
            Self::Imoa => Box::new(Imoa::<D, 12>::new(space, ImoaSettings::new(most), seed)?),
            Self::Pso => Box::new(Pso::<D, 20>::new(space, PsoSettings::new(most), seed)?),
            Self::DifferentialEvolution => {
                let settings = DifferentialEvolutionSettings::new(most);
                Box::new(DifferentialEvolution::<D, 24>::new(space, settings, seed)?)
            }
        };
        search.run(cost, most);
        Ok(*search.best().0)
    }
}

/// A cost of theta's change from the start, seen in whitened coordinates: the box [-1, 1]^12 reaches `radius`
/// posterior deviations.
struct Whitened<'a> {
    cost: &'a dyn Fn(&Theta) -> f64,
    factor: Cholesky<f64, Const<12>>,
    radius: f64,
}

impl Whitened<'_> {
    fn change(&self, y: &[f32; 12]) -> Theta {
        let y = Theta::from_fn(|i, _| self.radius * f64::from(y[i]));
        self.factor.l().tr_solve_lower_triangular(&y).unwrap_or_else(Theta::zeros)
    }
}

impl Cost<12> for Whitened<'_> {
    fn evaluate(&self, y: &[f32; 12]) -> f32 {
        (self.cost)(&self.change(y)) as f32
    }
}

/// Searches `radius` posterior deviations about a start for the lowest cost of the change from it; no change
/// when the normal matrix at the start is none.
pub(super) fn search_about(
    search: Search,
    cost: &dyn Fn(&Theta) -> f64,
    normal: Matrix12,
    radius: f64,
    (most, seed): (u32, u64),
    spent: &mut Spent,
) -> Theta {
    let Some(factor) = normal.cholesky() else { return Theta::zeros() };
    spent.matrices += 1;
    spent.evaluations += most;
    let whitened = Whitened { cost, factor, radius };
    let found = search.best(&whitened, &SearchSpace::UNIT, most, seed);
    found.map_or_else(|_| Theta::zeros(), |y| whitened.change(&y))
}
