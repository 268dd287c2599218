//! Products of slices, eight elements at a time: a loop then costs a Cortex-M4F an eighth of what it would.

use super::real::Real;

const TOGETHER: usize = 8;

/// Sum of products of two slices, in their order; elements beyond the end of the shorter one are ignored.
pub(super) fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let length = if a.len() < b.len() { a.len() } else { b.len() };
    let (a, b) = (a.get(..length).unwrap_or_default(), b.get(..length).unwrap_or_default());
    let ((eights, a), (others, b)) = (a.as_chunks::<TOGETHER>(), b.as_chunks::<TOGETHER>());
    let mut sum = T::ZERO;
    for (eight, other) in eights.iter().zip(others) {
        sum = eight.iter().zip(other).fold(sum, |sum, (a, b)| sum + *a * *b);
    }
    a.iter().zip(b).fold(sum, |sum, (a, b)| sum + *a * *b)
}

/// Adds a multiple of a slice to another, as far as both reach.
pub(super) fn add_times<T: Real>(to: &mut [T], factor: T, by: &[T]) {
    let length = if to.len() < by.len() { to.len() } else { by.len() };
    let (to, by) = (to.get_mut(..length).unwrap_or_default(), by.get(..length).unwrap_or_default());
    let ((eights, to), (others, by)) = (to.as_chunks_mut::<TOGETHER>(), by.as_chunks::<TOGETHER>());
    for (eight, other) in eights.iter_mut().zip(others) {
        for (to, by) in eight.iter_mut().zip(other) {
            *to += factor * *by;
        }
    }
    for (to, by) in to.iter_mut().zip(by) {
        *to += factor * *by;
    }
}

/// Elements that take two multiples in one pass of a loop.
const FEW: usize = 4;

/// Adds multiples of two slices to another, the first and then the second, which are as long or longer. Each sum is
/// loaded and stored once for both.
#[inline(always)]
pub(super) fn add_two_times<T: Real>(to: &mut [T], [f, g]: [T; 2], [a, b]: [&[T]; 2]) {
    let length = to.len();
    let (Some(a), Some(b)) = (a.get(..length), b.get(..length)) else { return };
    let ((fours, to), (of_a, a), (of_b, b)) = (to.as_chunks_mut::<FEW>(), a.as_chunks::<FEW>(), b.as_chunks::<FEW>());
    for ((four, a), b) in fours.iter_mut().zip(of_a).zip(of_b) {
        for ((to, a), b) in four.iter_mut().zip(a).zip(b) {
            *to = *to + f * *a + g * *b;
        }
    }
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to = *to + f * *a + g * *b;
    }
}

#[cfg(test)]
mod tests;
