//! Field turned by more than the gyro measures: either may be wrong, and the attitude is uncertain while this lasts.

use crate::statistics::chi_square::IN_A_THOUSAND;
use nalgebra::Vector3;

/// Averaging time of the readings' scatter, seconds. A doubted reading enters the mean only up to the gate: a
/// turn by a radian stays doubted until the mean is some ten thousand times larger, for two seconds, in which
/// the filter finds the cause.
const SMOOTHING_S: f32 = 1.0;
/// Largest weight of a reading in that mean, which is then over nine readings of three axes: it is known to a quarter
/// (sqrt(2 / 27)).
const MOST_WEIGHT: f32 = 0.2;
/// Scatter assumed before the first reading, microtesla: more than the earth's field.
const UNKNOWN_UT: f32 = 100.0;
/// Gate over the mean square: exceeded by noise once in a thousand (chi-square with three degrees of
/// freedom).
const GATE: f32 = IN_A_THOUSAND / 3.0;

/// Apparent turn of the earth's field since it last agreed with the attitude, reading by reading.
///
/// The earth's field does not turn. If no disturbance came, the attitude is wrong, and until the filter knows which it
/// is, the attitude may be off by this apparent turn. A gyro that fails while the probe turns is off by degrees within
/// a hundredth of a second.
pub(super) struct TurnedField {
    /// Field of the last agreement, NED; zero before the first.
    agreed_ut: Vector3<f32>,
    /// Mean square of the readings' difference from `agreed_ut`.
    noise_ut2: f32,
    /// Excess of the last reading's squared difference over the gate.
    doubt_ut2: f32,
    /// Time since the last reading, seconds.
    unread_s: f32,
}

impl TurnedField {
    /// All zero, for a static.
    pub(super) const fn zero() -> Self {
        Self { agreed_ut: Vector3::new(0.0, 0.0, 0.0), noise_ut2: 0.0, doubt_ut2: 0.0, unread_s: 0.0 }
    }

    /// Creates a detector with no reading in doubt.
    pub(super) const fn new() -> Self {
        Self { noise_ut2: UNKNOWN_UT * UNKNOWN_UT, ..Self::zero() }
    }

    /// Takes a step's mean field, NED, that agreed with the attitude; ignored while the last reading is in
    /// doubt.
    pub(super) fn agree(&mut self, field_ut: &Vector3<f32>) {
        if self.doubt_ut2 <= 0.0 {
            self.agreed_ut = *field_ut;
        }
    }

    /// Adds the time from the sample before to this one, with or without a field.
    pub(super) fn pass(&mut self, step_s: f32) {
        self.unread_s += step_s;
    }

    /// Takes a reading of the field, north, east and down. Returns true if it is further from the last field that
    /// agreed with the attitude than the noise allows.
    pub(super) fn update(&mut self, field_ut: &Vector3<f32>) -> bool {
        let weight = core::mem::replace(&mut self.unread_s, 0.0) / SMOOTHING_S;
        let square = (field_ut - self.agreed_ut).norm_squared();
        let beyond = square - GATE * self.noise_ut2;
        self.doubt_ut2 = if beyond > 0.0 { beyond } else { 0.0 };
        self.noise_ut2 +=
            (square - self.doubt_ut2 - self.noise_ut2) * if weight < MOST_WEIGHT { weight } else { MOST_WEIGHT };
        self.doubt_ut2 > 0.0
    }

    /// Raises an existing doubt to at least this squared angle, rad^2.
    pub(super) fn doubt_at_least(&mut self, square: f32) {
        let square_ut2 = square * self.agreed_ut.norm_squared();
        if self.doubt_ut2 > 0.0 && square_ut2 > self.doubt_ut2 {
            self.doubt_ut2 = square_ut2;
        }
    }

    /// Squared angle in doubt, rad^2, as a chord; 0 before any field has agreed.
    pub(super) fn doubt(&self) -> f32 {
        let square_ut2 = self.agreed_ut.norm_squared();
        if self.doubt_ut2 > 0.0 && square_ut2 > 0.0 { self.doubt_ut2 / square_ut2 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests;
