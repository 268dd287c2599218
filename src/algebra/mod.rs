//! Fixed-size linear algebra beyond 3x3: packed symmetric matrices, their Cholesky factor, dot products and
//! quantiles.
//!
//! nalgebra's own product is not used for these sizes. It changes with features that other crates switch on,
//! so the host could differ from the chip in the last bit; and packing halves the memory of matrices in
//! static RAM.

mod cholesky;
mod dot;
mod packed;
mod quantile;
mod whitening;

pub(crate) use dot::dot;
pub(crate) use packed::Cholesky;
pub use packed::Packed;
pub(crate) use quantile::quantile;
pub(crate) use whitening::Whitening;
