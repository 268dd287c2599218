use super::*;

#[test]
fn quantiles_of_known_numbers() {
    assert_eq!(quantile(&mut [3.0, 1.0, 2.0], 0.5), 2.0);
    assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 0.5), 3.0);
    assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 0.25), 2.0);
    assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 1.0), 4.0);
    assert_eq!(quantile(&mut [], 0.5), 0.0);
}
