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
