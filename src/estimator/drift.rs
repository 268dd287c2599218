//! Drift of the learnt values while the probe was off. Nobody knows for how long it was off, or whether it fell. So the
//! figures are those that data sheets give whatever the time: for a part's life, or for a change of temperature.

use super::columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, MAG_MATRIX};

/// Change of temperature that is allowed for, kelvin: a model is stored for every ten.
const CHANGE_K: f32 = 10.0;

/// Drift of an element of P: the tolerance of sensitivity, 1 % (LSM6DSO, data sheet, mechanical characteristics). The
/// sensitivity's change with temperature, 0.007 %/K, is small beside that.
pub const P_DRIFT: f32 = 0.01;

/// Deviation of the drift of a nuisance, in its unit. `None`: nothing is left of what was learnt, for steel is
/// magnetised anew, a bias is another one at every start, and the magnetometer's lag is the phase of two clocks that
/// start anew. P's drift is in its prior: see [`Estimator::restore`](super::Estimator::restore).
fn deviation(column: usize) -> Option<f32> {
    if MAG_MATRIX.columns().contains(&column) {
        // Sensitivity, 0.03 %/K (LSM303AGR, data sheet, magnetic characteristics).
        Some(3e-4 * CHANGE_K)
    } else if ACCEL_LAG.columns().contains(&column) {
        // The accelerometer is on the same chip and clock as the gyro.
        Some(0.0)
    } else if ACCEL_MATRIX.columns().contains(&column) {
        // Sensitivity, 0.01 %/K (LSM6DSO, as above).
        Some(1e-4 * CHANGE_K)
    } else if ACCEL_BIAS.columns().contains(&column) {
        // Zero-g level, 0.1 mg/K (LSM6DSO, as above).
        Some(9.81e-4 * CHANGE_K)
    } else {
        None
    }
}

/// Kept share of a column's deviation, given the width of its prior. A drifting value is drawn back to the prior by
/// as much as keeps the prior what it is; a drift as wide as the prior leaves nothing.
pub(super) fn kept(column: usize, width: f32) -> f32 {
    match deviation(column) {
        Some(drift) if drift < width => libm::sqrtf(1.0 - drift * drift / (width * width)),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests;
