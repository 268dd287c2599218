//! Chi-square quantiles with three degrees of freedom: how improbable a vector is under its covariance.

/// Exceeded once in a million: with five nodes a second once in 55 hours.
pub(super) const IN_A_MILLION: f32 = 30.66;
/// Exceeded once in a thousand.
pub(super) const IN_A_THOUSAND: f32 = 16.27;
/// Exceeded once in a hundred; three in a row are one in a million.
pub(super) const IN_A_HUNDRED: f32 = 11.34;
/// Exceeded once in twenty: a node beyond it weighs less.
pub(super) const CLIPPED: f32 = 7.815;
