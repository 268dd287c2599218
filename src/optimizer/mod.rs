//! Optimisers over any cost of fixed dimension `D`: no allocation, seeded, resumable in slices, never
//! accepting a NaN. They know nothing of gyroscopes.
//!
//! A cost implements [`Cost`] (and [`LeastSquaresCost`] if it is a sum of squares). A [`SearchSpace`] bounds
//! the search and starts it. One of the optimisers is made over it, and [`Optimizer::run`] is called as often
//! as there is time:
//!
//! | optimiser | method | source |
//! |---|---|---|
//! | [`Imoa`] | improved meerkat optimisation, our reading | eq 9 to 29 of the paper, in any coordinates |
//! | [`LevenbergMarquardt`] | damped Gauss-Newton, for costs with normal equations | Marquardt, J. SIAM 11 (1963) 431 |
//!
//! With the feature `baseline-searches` also those that it is compared with:
//!
//! | optimiser | method | source |
//! |---|---|---|
//! | `ImoaLiteral` | IMOA as printed | eq 15 to 29 |
//! | `Moa` | meerkat optimisation | eq 9 to 14; Xian and Feng, Expert Syst. Appl. 231 (2023) 120482 |
//! | `Pso` | global-best particle swarm with constriction | Clerc and Kennedy, IEEE Trans. Evol. Comput. 6 (2002) 58 |
//! | `DifferentialEvolution` | DE/rand/1/bin | Storn and Price, J. Global Optimization 11 (1997) 341 |
//! | `RandomSearch` | uniform draws; the floor of every comparison | |
//!
//! Equal cost, space, settings and seed give the same result to the last bit, however the work is sliced. A
//! cost that is not finite counts as infinite.
//!
//! ```
//! use meerkat_mwd::optimizer::{Cost, Found, Imoa, ImoaSettings, Optimizer, OptimizerError, Progress, SearchSpace};
//!
//! struct Bowl;
//! impl Cost<2> for Bowl {
//!     fn evaluate(&self, x: &[f32; 2]) -> f32 {
//!         (x[0] - 0.3) * (x[0] - 0.3) + (x[1] + 2.0) * (x[1] + 2.0)
//!     }
//! }
//!
//! let space = SearchSpace::within([-1.0, -10.0], [1.0, 10.0])?;
//! let mut search = Imoa::<2, 12>::new(&space, ImoaSettings::new(1_000), 1)?;
//! while search.run(&Bowl, 100) == Progress::Running { /* something more urgent */ }
//! let (x, cost) = search.best();
//! assert!(cost < 1e-3 && (x[0] - 0.3).abs() < 0.05);
//! # Ok::<(), OptimizerError>(())
//! ```

#[cfg(feature = "baseline-searches")]
mod baselines;
mod imoa;
mod levenberg_marquardt;
mod population;
mod random;
mod search_space;

pub use crate::algebra::Packed;
#[cfg(feature = "baseline-searches")]
pub use baselines::{
    DifferentialEvolution, DifferentialEvolutionSettings, ImoaLiteral, ImoaLiteralSettings, Moa, MoaSettings, Pso,
    PsoSettings, RandomSearch,
};
pub use imoa::{Imoa, ImoaSettings, Reward};
pub use levenberg_marquardt::{LeastSquaresCost, LevenbergMarquardt};
pub use search_space::{OptimizerError, SearchSpace};

/// Function of `D` variables to be minimised.
pub trait Cost<const D: usize> {
    /// Returns the cost at `x`, in the caller's units; NaN and infinities count as infinite. Must be the same
    /// for the same `x`.
    fn evaluate(&self, x: &[f32; D]) -> f32;
}

/// State of a resumable search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Progress {
    /// There are evaluations left.
    Running,
    /// The evaluations are used up, or nothing can improve.
    Done,
}

/// Result of a search, whatever its cost is.
pub trait Found<const D: usize> {
    /// Returns the lowest point evaluated so far and its cost; the start and infinity while no cost was
    /// finite. The cost never rises.
    fn best(&self) -> (&[f32; D], f32);

    /// Number of evaluations spent so far.
    fn evaluations(&self) -> u32;
}

/// Search for the lowest point of a cost `C` of `D` variables, done in pieces.
pub trait Optimizer<C: ?Sized, const D: usize>: Found<D> {
    /// Does the smallest piece of work: at most one evaluation of the cost, which must be the same function
    /// at every step.
    fn step(&mut self, cost: &C) -> Progress;

    /// Does at most `budget` steps.
    fn run(&mut self, cost: &C, budget: u32) -> Progress {
        for _ in 0..budget {
            if self.step(cost) == Progress::Done {
                return Progress::Done;
            }
        }
        Progress::Running
    }
}

/// Cost at `x`; infinite wherever it is not finite.
fn finite_cost<const D: usize>(cost: &(impl Cost<D> + ?Sized), x: &[f32; D]) -> f32 {
    let found = cost.evaluate(x);
    if found.is_finite() { found } else { f32::INFINITY }
}
