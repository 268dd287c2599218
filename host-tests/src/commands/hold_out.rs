//! The share of a trace that `--hold-out` keeps back.

/// Parses a share between 0 and 1.
///
/// # Errors
/// The text is no number, or one outside the range.
pub(super) fn hold_out(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(fraction) if fraction > 0.0 && fraction < 1.0 => Ok(fraction),
        _ => Err("must be a number between 0 and 1, both excluded".to_owned()),
    }
}
