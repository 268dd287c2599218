//! Differences of errors that count: a ratio that is more than noise, and an amount that matters.

/// Ratio of errors that counts as a clear difference.
pub(super) const CLEARLY: f64 = 1.05;

/// Difference of errors that matters, degrees.
pub(super) const MATTERS_DEG: f64 = 0.1;

/// Returns true if the second error is clearly larger than the first.
pub(super) fn is_worse([without, with]: &[f64; 2]) -> bool {
    *with > CLEARLY * without
}

/// Returns true if it is, and by an amount that matters; errors in degrees.
pub(super) fn is_worse_by_what_matters(errors: &[f64; 2]) -> bool {
    let [without, with] = errors;
    is_worse(errors) && *with > without + MATTERS_DEG
}
