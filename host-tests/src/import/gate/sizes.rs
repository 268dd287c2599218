//! Sizes that gravity and the earth's field have, and the typical size of readings.

use std::ops::RangeInclusive;

/// Gravity that the pipeline takes (`Earth::gravity_m_s2`), m/s^2: an accelerometer's scale may be off, a unit not.
pub(super) const GRAVITY: RangeInclusive<f64> = 9.0..=10.5;
/// The earth's field, microtesla (World Magnetic Model: 22 to 67).
pub(super) const FIELD: RangeInclusive<f64> = 20.0..=70.0;

/// Median; NaN of no values.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { f64::NAN } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
