//! Rest, as the attitude filter and the surveys judge it: readings that stay the same. A turn too slow for the gyro to
//! be told from its bias is found by `slow_turn`. The estimator has its own detector, `estimator/rest.rs`.

use nalgebra::Vector3;

/// Time constant of the readings' mean, seconds (VQF's default).
const SMOOTHING_S: f32 = 0.5;
/// Largest smoothed rate at rest, and largest deviation from it, rad/s: 2 deg/s, VQF's default (Laidig and
/// Seel, Information Fusion 91, 2023), above the noise and the bias of a compensated MEMS gyro.
pub(super) const RATE_RAD_S: f32 = 0.035;
/// Largest deviation of the specific force at rest, m/s^2 (VQF's default).
const FORCE_M_S2: f32 = 0.5;
/// Slowest swing that counts as rest, hertz: at 2 deg/s its amplitude is a third of a degree. Acceleration over 2 pi
/// times this is speed.
const SWING_HZ: f32 = 1.0;
/// Least speed assumed at rest, m/s: a slower swing, by a degree in a second at an arm of a third of a metre.
const LEAST_SPEED_M_S: f32 = 5e-3;
/// Quiet time after which the probe is at rest, seconds (VQF's default).
const QUIET_S: f32 = 1.5;

/// Longest time without a force in which rest is still believed, seconds: accelerometers are read at 12.5 Hz
/// and faster.
const UNSEEN_S: f32 = 0.1;

/// Detector of rest by readings that stay the same. It cannot tell a slow, perfectly steady rotation from a bias, so
/// its users must bound a bias found at rest.
pub(crate) struct RestTracker {
    rate_rad_s: Vector3<f32>,
    force_m_s2: Vector3<f32>,
    /// Smoothed square of the force's deviation from its mean, (m/s^2)^2.
    square_deviation: f32,
    quiet_s: f32,
    unseen_s: f32,
    started: bool,
}

impl RestTracker {
    pub(crate) const fn new() -> Self {
        Self {
            rate_rad_s: Vector3::new(0.0, 0.0, 0.0),
            force_m_s2: Vector3::new(0.0, 0.0, 0.0),
            square_deviation: 0.0,
            quiet_s: 0.0,
            unseen_s: 0.0,
            started: false,
        }
    }

    /// Takes one reading; the force may be missing for moments, where the accelerometer is read less often
    /// than the gyro.
    pub(crate) fn update(&mut self, rate_rad_s: &Vector3<f32>, force_m_s2: Option<&Vector3<f32>>, dt_s: f32) {
        self.unseen_s = if force_m_s2.is_some() { 0.0 } else { self.unseen_s + dt_s };
        if self.unseen_s > UNSEEN_S || (force_m_s2.is_none() && !self.started) {
            self.quiet_s = 0.0;
            return;
        }
        let force_m_s2 = force_m_s2.copied().unwrap_or(self.force_m_s2);
        if !self.started {
            (self.rate_rad_s, self.force_m_s2, self.started) = (*rate_rad_s, force_m_s2, true);
        }
        let k = dt_s / (SMOOTHING_S + dt_s);
        self.rate_rad_s += (rate_rad_s - self.rate_rad_s) * k;
        self.force_m_s2 += (force_m_s2 - self.force_m_s2) * k;
        let square_deviation = (force_m_s2 - self.force_m_s2).norm_squared();
        self.square_deviation += (square_deviation - self.square_deviation) * k;
        let quiet = (rate_rad_s - self.rate_rad_s).norm_squared() < RATE_RAD_S * RATE_RAD_S
            && self.rate_rad_s.norm_squared() < RATE_RAD_S * RATE_RAD_S
            && square_deviation < FORCE_M_S2 * FORCE_M_S2;
        self.quiet_s = if !quiet {
            0.0
        } else if self.quiet_s < QUIET_S {
            self.quiet_s + dt_s
        } else {
            self.quiet_s
        };
    }

    /// Mean square of the speed at rest, (m/s)^2: of a swing that explains the force's variation, plus that of a slow
    /// swing.
    pub(crate) fn square_speed(&self) -> f32 {
        self.square_deviation / (core::f32::consts::TAU * SWING_HZ * core::f32::consts::TAU * SWING_HZ)
            + LEAST_SPEED_M_S * LEAST_SPEED_M_S
    }

    /// Spectral density of the force's noise at rest, (m/s^2)^2/Hz, for readings `dt_s` seconds apart: all
    /// variation counts as noise.
    pub(crate) fn force_density(&self, dt_s: f32) -> f32 {
        self.square_deviation * dt_s
    }

    /// Returns true while the probe is at rest.
    pub(crate) const fn detected(&self) -> bool {
        self.quiet_s >= QUIET_S
    }
}

#[cfg(test)]
mod tests;
