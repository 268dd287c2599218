//! Chi-square quantiles with three degrees of freedom, if no other number is named: how improbable a vector is under
//! its covariance.

/// Exceeded once in a million.
pub(crate) const IN_A_MILLION: f32 = 30.66;
/// Exceeded once in a thousand.
pub(crate) const IN_A_THOUSAND: f32 = 16.27;
/// Exceeded once in a hundred; three times in a row about once in a million.
pub(crate) const IN_A_HUNDRED: f32 = 11.34;
/// Exceeded once in twenty.
pub(crate) const IN_TWENTY: f32 = 7.815;
/// With two degrees of freedom exceeded once in a thousand.
pub(crate) const OF_TWO_IN_A_THOUSAND: f32 = 13.82;

#[cfg(test)]
mod tests;
