//! Rates that were not read, and time that was not seen.

use super::{AttitudeFilter, BIAS, LOST_RAD, PI, Rest};

/// A rate that is assumed where none was read, added to the last one, rad/s: a probe that turns as slowly as VQF's 20 deg/s counts as still.
const UNSEEN_RATE_RAD_S: f32 = 0.3;
/// A rate that is not read is another one after this time, seconds: of a swing at half a hertz a radian.
const UNREAD_RATE_TIME_S: f32 = 0.3;

impl AttitudeFilter {
    /// The rotation of this sample is uncertain by `angle_rad` about each axis, beyond the gyro's noise (held or clipped rate).
    pub fn doubt(&mut self, angle_rad: f32) {
        for k in 0..3 {
            self.errors.widen(k, angle_rad * angle_rad, PI * PI);
        }
        self.sigmas_stale = true;
    }

    /// The rate just propagated was not read (held, clipped or frozen), nor were those of the `unread_s` seconds up to now, this step
    /// of `dt_s` included. The error of the rate grows from nothing to the rate itself, the angle's with its square, then linearly.
    pub fn unread(&mut self, dt_s: f32, unread_s: f32) {
        let rate_rad_s = libm::sqrtf(self.rate_rad_s.norm_squared()) + UNSEEN_RATE_RAD_S;
        let angle_rad = |s: f32| {
            let late = s > UNREAD_RATE_TIME_S;
            rate_rad_s * if late { s - 0.5 * UNREAD_RATE_TIME_S } else { 0.5 * s * s / UNREAD_RATE_TIME_S }
        };
        let (before, now) = (angle_rad(unread_s - dt_s), angle_rad(unread_s));
        self.doubt(libm::sqrtf(now * now - before * before));
    }

    /// `dt_s` seconds before this sample were not seen: the attitude is kept, its uncertainty grows by what the probe may have
    /// turned, and when that is much, gravity and field are taken anew as soon as they are seen. To be followed by
    /// [`AttitudeFilter::observe`] without [`AttitudeFilter::propagate`].
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
