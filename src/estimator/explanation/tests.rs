extern crate std;

use super::*;
use std::vec::Vec;

#[test]
fn a_mean_of_logarithms_is_the_logarithm_of_the_mean() {
    let mut mean = LogMean::new();
    [200.0_f32, 210.0, 205.0].iter().for_each(|log| mean.add(*log));
    let expected = 210.0 + ((1.0 + libm::exp(-5.0) + libm::exp(-10.0)) / 3.0).ln() as f32;
    assert!((mean.get() - expected).abs() < 1e-4, "{}", mean.get());
}

#[test]
fn every_set_of_widths_comes_once_and_one_of_them_is_the_data_sheets() {
    for grid in [Widths::HAND, Widths::DRILL_STRING] {
        let mut sets: Vec<_> = Sets::of(&grid).collect();
        assert_eq!(sets.iter().filter(|set| grid.sheets(**set) == [true; GROUPS]).count(), 1);
        sets.sort_unstable();
        sets.dedup();
        assert_eq!(sets.len(), grid.count.iter().product());
    }
}
