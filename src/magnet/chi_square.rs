//! Quantiles of chi-square with three degrees of freedom: how unlikely a vector is under its covariance.

/// One in a million: with five nodes a second one in 55 hours.
pub(super) const IN_A_MILLION: f32 = 30.66;
/// One in a thousand.
pub(super) const IN_A_THOUSAND: f32 = 16.27;
/// One in a hundred; three in a row are one in a million.
pub(super) const IN_A_HUNDRED: f32 = 11.34;
/// One in twenty: beyond it a node weighs less.
pub(super) const CLIPPED: f32 = 7.815;
