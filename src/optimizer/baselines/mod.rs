//! Searches that IMOA is compared with.

mod differential_evolution;
mod imoa_literal;
mod incumbent;
mod moa;
mod pso;
mod random_search;

pub use differential_evolution::{DifferentialEvolution, DifferentialEvolutionSettings};
pub use imoa_literal::{ImoaLiteral, ImoaLiteralSettings};
pub use moa::{Moa, MoaSettings};
pub use pso::{Pso, PsoSettings};
pub use random_search::RandomSearch;
