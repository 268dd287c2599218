//! Dot product in a fixed order of summation: the chip and the host give the same bits.

/// Dot product of two vectors, summed from the first element on.
pub(crate) fn dot<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
}
