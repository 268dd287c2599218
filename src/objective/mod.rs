//! What a candidate set of gyro parameters is worth on a window.

mod constraints;
mod innovation_filter;
mod innovations;
mod robust_loss;

pub(crate) use constraints::{fit_for_use, rotation_disagreement};
pub(crate) use innovation_filter::{InnovationFilter, Noise};
pub(crate) use innovations::{Innovations, STRETCHES, Stretch, add_equations, rescale};
