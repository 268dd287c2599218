//! Interruptions: rates that were not read, and gaps in time.

use super::{AttitudeFilter, BIAS, LOST_RAD, PI, Rest};

/// Rate added to the last one where none was read, rad/s: VQF counts a probe that turns at 20 deg/s as still.
const UNSEEN_RATE_RAD_S: f32 = 0.3;
/// Correlation time of an unread rate, seconds: a radian of a swing at half a hertz.
const UNREAD_RATE_TIME_S: f32 = 0.3;

impl AttitudeFilter {
    /// Inflates the attitude by `angle_rad` about each axis, for a rotation that the gyro did not see in full
    /// (rate held or clipped).
    pub fn doubt(&mut self, angle_rad: f32) {
        for k in 0..3 {
            self.errors.widen(k, angle_rad * angle_rad, PI * PI);
        }
        self.sigmas_stale = true;
    }

    /// Inflates the attitude for an unread rate (held, clipped or frozen), the last of `unread_s` seconds of
    /// them, this step's `dt_s` included. The rate's error grows from nothing to the rate itself; the angle's
    /// grows with the square of time, then linearly.
    pub fn unread(&mut self, dt_s: f32, unread_s: f32) {
        let rate_rad_s = libm::sqrtf(self.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S;
        let angle_rad = |s: f32| {
            let late = s > UNREAD_RATE_TIME_S;
            rate_rad_s * if late { s - 0.5 * UNREAD_RATE_TIME_S } else { 0.5 * s * s / UNREAD_RATE_TIME_S }
        };
        let (before, now) = (angle_rad(unread_s - dt_s), angle_rad(unread_s));
        self.doubt(libm::sqrtf(now * now - before * before));
    }

    /// Passes over `dt_s` seconds without samples. The attitude stays; its uncertainty grows by the turn that
    /// may have happened, and if that is large, gravity and field align the filter again. Call
    /// [`AttitudeFilter::observe`] next, without [`AttitudeFilter::propagate`].
    pub fn gap(&mut self, dt_s: f32) {
        let Some((config, _)) = self.settings() else { return };
        let limited_s = if dt_s < 100.0 { dt_s } else { 100.0 };
        let angle_rad = (libm::sqrtf(self.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S) * limited_s;
        self.doubt(if angle_rad < PI { angle_rad } else { PI });
        let walk = config.gyro_bias_walk_rad_s_rts * config.gyro_bias_walk_rad_s_rts * limited_s;
        for k in 0..3 {
            self.errors.widen(BIAS + k, walk, config.gyro_bias_sigma_rad_s * config.gyro_bias_sigma_rad_s);
        }
        self.stop(&config);
        self.propagation.interrupt();
        self.rest = Rest::new();
        self.lost = self.lost || angle_rad > LOST_RAD;
        self.after_gap = true;
        self.step_s = 0.0;
    }
}
