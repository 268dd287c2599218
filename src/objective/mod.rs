//! What a candidate set of gyro parameters is worth on a window.

mod noise_scale;
mod robust_loss;
mod two_vector;

pub(crate) use noise_scale::noise_scales;
pub(crate) use two_vector::{NoiseScales, TwoVector, turn};
