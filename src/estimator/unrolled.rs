//! Products of slices, eight elements at a time: a loop then costs a Cortex-M4F an eighth of what it would.

use super::real::Real;

const TOGETHER: usize = 8;

/// Sum of products of two slices, in their order; the longer one's end counts for nothing.
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

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn every_element_that_both_have_counts_once() {
        for (n, m) in [(0, 3), (7, 7), (8, 9), (25, 16), (40, 41)] {
            let a: Vec<f64> = (0..n).map(|k| f64::from(k) + 1.0).collect();
            let b: Vec<f64> = (0..m).map(|k| 2.0 - f64::from(k)).collect();
            assert_eq!(dot(&a, &b), a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>());
            let mut sum = a.clone();
            add_times(&mut sum, 0.5, &b);
            for (k, x) in sum.iter().enumerate() {
                assert_eq!(*x, a[k] + b.get(k).map_or(0.0, |b| 0.5 * b));
            }
        }
    }
}
