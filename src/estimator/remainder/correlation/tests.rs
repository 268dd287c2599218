use super::*;

#[test]
fn the_tables_are_of_one_size() {
    assert_eq!(GROUPS.iter().sum::<usize>(), REGRESSORS);
    assert_eq!(GROUPS.iter().map(|width| width * (width + 1) / 2).sum::<usize>(), PRODUCTS);
    assert_eq!(VIEWED.iter().map(|(group, _)| GROUPS[*group]).sum::<usize>(), CROSS);
    assert!(TESTS.iter().all(|(_, viewed, counted)| counted.end <= GROUPS[VIEWED[*viewed].0]));
    assert!(GROUPS.iter().all(|width| *width <= WIDEST));
}

/// Critical values of F (any table).
#[test]
fn the_chance_of_a_ratio_is_that_of_the_tables() {
    for (ratio, freedom, left, chance) in [
        (2.922, 3.0, 30.0, 0.05),
        (4.510, 3.0, 30.0, 0.01),
        (7.054, 3.0, 30.0, 0.001),
        (4.393, 9.0, 30.0, 0.001),
        (13.74, 2.0, 12.0, 0.000_8),
        (4.351, 1.0, 20.0, 0.05),
    ] {
        let p = chance_of_ratio(ratio, freedom, left);
        assert!((p / chance - 1.0).abs() < 0.12, "{p} for {chance}");
    }
}
