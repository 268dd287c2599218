//! Fixed-size linear algebra beyond 3x3: packed symmetric matrices, their Cholesky factor, a Jacobi eigen-solver and
//! quantiles.
//!
//! nalgebra's own product and eigen-solver are not used for these sizes: its product changes with the features that other
//! crates switch on (so the host could differ from the chip in the last bit), its `SymmetricEigen` can panic, and packing
//! halves the memory of the normal matrices that stand in static RAM.

mod cholesky;
#[allow(dead_code)] // The estimator's.
mod eigen;
mod packed;
mod quantile;
#[allow(dead_code)] // The estimator's.
mod vectors;

pub(crate) use cholesky::{factorise, solve_lower, solve_upper};
#[allow(unused_imports)] // The estimator's.
pub(crate) use eigen::Jacobi;
#[allow(unused_imports)] // The estimator's.
pub(crate) use packed::Cholesky;
pub use packed::Packed;
pub(crate) use packed::add_outers;
pub(crate) use quantile::quantile;
#[allow(unused_imports)] // The estimator's.
pub(crate) use vectors::{add_scaled, dot, minus, plus};
