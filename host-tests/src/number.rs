//! Numbers as a reader sees them.

/// A number with so many decimals, and never a zero with a minus.
#[must_use]
pub fn fixed(x: impl Into<f64>, decimals: usize) -> String {
    let text = format!("{:.decimals$}", x.into());
    match text.strip_prefix('-') {
        Some(size) if size.bytes().all(|letter| matches!(letter, b'0' | b'.')) => size.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_minus_and_all_else_keeps_its_own() {
        let both = [(-0.0, 1), (-0.004, 2), (-0.006, 2), (0.0, 0), (-12.0, 0), (f64::NAN, 1)];
        assert_eq!(both.map(|(x, decimals)| fixed(x, decimals)), ["0.0", "0.00", "-0.01", "0", "-12", "NaN"]);
    }
}
