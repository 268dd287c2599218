//! Fixed-size linear algebra beyond 3x3: packed symmetric matrices, their Cholesky factor, a Jacobi eigen-solver and
//! quantiles.
//!
//! nalgebra's own product and eigen-solver are not used for these sizes: its product changes with the features that other
//! crates switch on (so the host could differ from the chip in the last bit), its `SymmetricEigen` can panic, and packing
//! halves the memory of the normal matrices that stand in static RAM.

mod cholesky;
mod eigen;
mod packed;
mod quantile;
mod vectors;

pub(crate) use cholesky::{factorise, solve_lower, solve_upper};
pub(crate) use eigen::Jacobi;
pub use packed::Packed;
pub(crate) use packed::{Cholesky, add_outers};
pub(crate) use quantile::quantile;
pub(crate) use vectors::{add_scaled, dot, minus, plus};
