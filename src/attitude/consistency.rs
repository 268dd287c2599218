//! Consistency of the stated covariance with the innovations: their squares over the variances expected of them.

use crate::change::TURNING_RAD_S;
use nalgebra::{Matrix3, Vector3};

/// Correlation time of the innovations, seconds: a turn by a radian at the slowest rate that counts as turning.
const CORRELATION_S: f32 = 1.0 / TURNING_RAD_S;
/// Time constant of the means, seconds: ten independent innovations.
const MEMORY_S: f32 = 10.0 * CORRELATION_S;
/// Largest ratio that counts, and that for which a NaN counts: two deviations, beyond which one in twenty is. The mean
/// of innovations as large as expected is then 0.9.
const MOST: f32 = 4.0;
/// Least ratio that is stated: ten independent innovations cannot show one below a tenth.
const LEAST: f32 = CORRELATION_S / MEMORY_S;

/// Means of the squared innovations, each over the variance that the filter expects. The filter's gain assumes the
/// largest errors that sensors and motion may have. The covariance that it states is smaller by these ratios: it is
/// that of the errors that the innovations show.
pub(super) struct Consistency {
    tilt: f32,
    heading: f32,
    /// That of the heading while the probe turns: it alone shows an error of the field that is constant in the probe.
    turning: f32,
}

impl Consistency {
    /// All zero, for a static.
    pub const ZERO: Self = Self { tilt: 0.0, heading: 0.0, turning: 0.0 };

    /// Means of one: innovations as large as expected.
    pub const fn new() -> Self {
        Self { tilt: 1.0, heading: 1.0, turning: 1.0 }
    }

    /// Takes the innovation of one of the two velocities at the end of a step: its square over its expected variance.
    pub fn note_velocity(&mut self, ratio: f32, time_s: f32) {
        note(&mut self.tilt, ratio, 0.5 * time_s);
    }

    /// Takes the innovation of the field's heading: its square over its expected variance, and the square of the rate
    /// at which the probe turns, (rad/s)^2.
    pub fn note_heading(&mut self, ratio: f32, squared_rate: f32, time_s: f32) {
        note(&mut self.heading, ratio, time_s);
        if squared_rate > TURNING_RAD_S * TURNING_RAD_S {
            note(&mut self.turning, ratio, time_s);
        }
    }

    /// Takes the shares of tilt's and heading's variances that are new, as after a gap: past innovations say nothing of
    /// them.
    pub fn note_added(&mut self, [tilt, heading]: [f32; 2]) {
        add(&mut self.tilt, tilt);
        add(&mut self.heading, heading);
    }

    /// Scales the expected covariance of the attitude error (NED, rad^2) by the means, and adds the variance of the
    /// heading that averaging does not reduce (rad^2). Half of that is taken to come from the probe, which shows while
    /// it turns, and half from the place, which does not show. Neither grows: innovations beyond their expectation are
    /// left to gates.
    pub fn stated(&self, covariance: &Matrix3<f32>, constant: f32) -> Matrix3<f32> {
        let (tilt, heading) = (deviation(self.tilt), deviation(self.heading));
        let by = Matrix3::from_diagonal(&Vector3::new(tilt, tilt, heading));
        let mut stated = by * covariance * by;
        let turning = deviation(self.turning);
        stated.m33 += 0.5 * constant * (1.0 + turning * turning);
        stated
    }
}

/// Moves a mean, up as slowly as down, so that it is that of the innovations.
fn note(mean: &mut f32, ratio: f32, time_s: f32) {
    let ratio = if ratio < MOST { ratio } else { MOST };
    *mean += (ratio - *mean) * (time_s / (MEMORY_S + time_s));
}

/// Moves a mean below one towards one by the share of the variance that is new, so that the variance stated grows by
/// what is new.
fn add(mean: &mut f32, share: f32) {
    if *mean < 1.0 {
        // A NaN counts as all.
        *mean += (1.0 - *mean) * if share < 1.0 { share } else { 1.0 };
    }
}

/// Factor of the stated deviation: root of a mean, at most one.
fn deviation(mean: f32) -> f32 {
    let limited = if mean < 1.0 { mean } else { 1.0 };
    libm::sqrtf(if limited > LEAST { limited } else { LEAST })
}

#[cfg(test)]
mod tests;
