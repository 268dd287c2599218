//! Median of a column's values.

/// Median, the upper one of an even number: it is a value that was read. `None` without values.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_of_two_is_the_median() {
        assert_eq!([median([]), median([2.0]), median([4.0, 1.0, 3.0, 2.0])], [None, Some(2.0), Some(3.0)]);
    }
}
