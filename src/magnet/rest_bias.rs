//! Bias of the raw gyro from rests, for the watch for magnets.

use super::rest::Rest;
use nalgebra::Vector3;

/// Bias of the raw gyro from seconds of rest: a scalar-variance Kalman filter with a random walk between
/// rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RestBias {
    /// Bias in the raw frame, rad/s.
    pub rate: Vector3<f32>,
    /// Variance on each axis, (rad/s)^2.
    pub variance: f32,
}

impl RestBias {
    /// In-run bias instability, rad/s, below which no bias from rests is believed: 0.01 deg/s, the upper end of
    /// consumer MEMS gyros' Allan plots in data sheets.
    const INSTABILITY_RAD_S: f32 = 1.75e-4;

    pub fn from_rest(rest: &Rest) -> Self {
        Self { rate: rest.rate, variance: measurement_variance(rest) }
    }

    /// Predicts over `seconds` of a bias random walk, rad/s per root second.
    pub fn predicted(mut self, seconds: f32, walk_rad_s_rts: f32) -> Self {
        self.variance += walk_rad_s_rts * walk_rad_s_rts * seconds;
        self
    }

    pub fn updated(self, rest: &Rest) -> Self {
        let measured = measurement_variance(rest);
        let gain = self.variance / (self.variance + measured);
        Self { rate: self.rate + (rest.rate - self.rate) * gain, variance: self.variance * (1.0 - gain) }
    }

    /// Standard deviation including the instability, rad/s.
    pub fn sigma_rad_s(&self) -> f32 {
        libm::sqrtf(self.variance + Self::INSTABILITY_RAD_S * Self::INSTABILITY_RAD_S)
    }
}

fn measurement_variance(rest: &Rest) -> f32 {
    // Rounding to the gyro's codes, about 1e-3 rad/s each, can make a second look quieter than it is.
    rest.variance / f32::from(rest.samples) + 1e-9
}

#[cfg(test)]
mod tests;
