//! Optimisers over any cost of fixed dimension: no allocation, seeded, resumable. They know nothing of gyroscopes.

mod imoa;
mod levenberg_marquardt;
mod random;

pub(crate) use imoa::{Imoa, ImoaSettings};
pub(crate) use levenberg_marquardt::{LeastSquaresCost, LevenbergMarquardt};

/// A function to be minimised.
pub(crate) trait Cost<const D: usize> {
    /// The cost at `x`; not finite counts as infinitely bad.
    fn evaluate(&self, x: &[f32; D]) -> f32;
}

/// Whether a resumable search has more to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    Running,
    Done,
}
