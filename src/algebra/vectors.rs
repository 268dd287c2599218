//! Vectors of fixed length.

/// Adds `weight * values` to the first of the sums.
#[inline(never)]
pub(crate) fn add_scaled(sums: &mut [f32], values: &[f32], weight: f32) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// a + b.
pub(crate) fn plus<const D: usize>(a: &[f32; D], b: &[f32; D]) -> [f32; D] {
    let mut sum = *a;
    for (x, y) in sum.iter_mut().zip(b) {
        *x += y;
    }
    sum
}

/// a - b.
pub(crate) fn minus<const D: usize>(a: &[f32; D], b: &[f32; D]) -> [f32; D] {
    let mut difference = *a;
    for (x, y) in difference.iter_mut().zip(b) {
        *x -= y;
    }
    difference
}

/// a . b.
pub(crate) fn dot<const D: usize>(a: &[f32; D], b: &[f32; D]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (x, y)| sum + x * y)
}
