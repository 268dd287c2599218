//! Sizes that gravity and the earth's field have.

use std::ops::RangeInclusive;

/// Gravity that the pipeline takes (`Earth::gravity_m_s2`), m/s^2: an accelerometer's scale may be off, a unit not.
pub(super) const GRAVITY: RangeInclusive<f64> = 9.0..=10.5;
/// The earth's field, microtesla (World Magnetic Model: 22 to 67).
pub(super) const FIELD: RangeInclusive<f64> = 20.0..=70.0;
