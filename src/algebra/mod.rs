//! Fixed-size linear algebra: packed symmetric matrices, Cholesky factors, dot products, quantiles, and the numbers in
//! which the estimator computes.
//!
//! nalgebra's own product is not used for these sizes. It changes with features that other crates switch on,
//! so the host could differ from the chip in the last bit; and packing halves the memory of matrices in
//! static RAM.

pub(crate) mod cholesky;
mod dot;
mod packed;
mod packed_cholesky;
mod quantile;
pub(crate) mod real;
mod whitening;

pub(crate) use dot::dot;
pub use packed::Packed;
pub(crate) use packed::PackedCholesky;
pub(crate) use quantile::quantile;
pub(crate) use whitening::Whitening;

/// Returns true if all numbers are finite.
#[inline(never)]
pub(crate) fn are_finite(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}
