//! Checks of a value in a scenario.

use super::error::ScenarioError;

/// An error for a field whose value is not `ok`.
pub(super) fn check(ok: bool, field: &'static str, must_be: &'static str) -> Result<(), ScenarioError> {
    if ok { Ok(()) } else { Err(ScenarioError::Field { field, must_be }) }
}

/// Returns true if a value lies between two others, bounds included; NaN does not.
pub(super) fn within(x: f64, low: f64, high: f64) -> bool {
    (low..=high).contains(&x)
}

/// Returns true if every value lies between minus and plus `limit`.
pub(super) fn all_within(values: &[f64], limit: f64) -> bool {
    values.iter().all(|&x| within(x, -limit, limit))
}
