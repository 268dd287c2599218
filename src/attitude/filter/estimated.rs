//! The estimator's results as the attitude takes them: a gyro model, and an attitude.

use super::AttitudeFilter;
use crate::{
    attitude::{consistency::Consistency, error_state::HEADING},
    compensation::GyroModel,
    estimator::KnownAttitude,
    rotation::{exp_quaternion, quaternion},
};
use nalgebra::{Quaternion, Vector3};

impl AttitudeFilter {
    /// Swaps the gyro model. The attitude stays. So does what the filter has learnt of the rate's error, at the rate of
    /// a sustained rotation or at rest: the residual bias takes the difference and keeps its deviation, so that the
    /// filter alone owns the bias. With another P an axis whose rate the new model knows better, by its deviations (P
    /// row-major, then b, rad/s), loses its residual bias. All axes lose it to a P that differs from what the filter
    /// has found of the scale by more than the gyro's stated error, and its own, for it was partly P's error; the new
    /// model's deviations then replace the configured ones where they are smaller. Before the first alignment no bias
    /// stays: none has been learnt.
    pub fn model_changed(&mut self, old: &GyroModel, new: &GyroModel, sigma: &[f32; 12]) {
        if !self.started {
            return;
        }
        let Self { state, heading, settings, motion, .. } = self;
        let before = state.bias_rad_s;
        // A mean that no rotation sustains is that of one which has just ended.
        let sustained = &motion.sustained;
        let rate_rad_s = sustained.axes().map_or_else(Vector3::zeros, |_| sustained.mean_rad_s());
        self.is_doubted |= self.sensors.change_model(state, heading, [old, new], sigma, &rate_rad_s, settings);
        if !self.tilt.aligned {
            state.bias_rad_s = Vector3::zeros();
        }
        motion.slow_turn.model_changed(&(state.bias_rad_s - before), old.p == new.p);
        self.report.is_stale |= old.p != new.p;
    }

    /// Returns true while the attitude is doubted: from a change of the gyro model that showed the former one wrong
    /// until [`AttitudeFilter::compare`].
    pub(crate) const fn is_doubted(&self) -> bool {
        self.is_doubted
    }

    /// Marks this instant, for which the estimator is asked for its attitude.
    pub(crate) const fn mark(&mut self) {
        self.state.propagation.mark();
    }

    /// Goes on from the estimator's attitude at the mark, with its covariance, if the estimator's tilt is more certain
    /// than the filter's and gravity does not contradict it; its heading is taken only if that is more certain, too.
    /// Does nothing without a mark, which a gap removes.
    pub(crate) fn compare(&mut self, known: &KnownAttitude) {
        let Self { state, heading, settings, .. } = self;
        let north = Vector3::new(0.0, 0.0, settings.earth.declination_rad.unwrap_or(0.0));
        let rotation = exp_quaternion(&north) * quaternion(&known.rotation);
        let Some(by) = state.propagation.since_mark(&rotation) else { return };
        self.is_doubted = false;
        let tilt = state.errors.variance(0) + state.errors.variance(1);
        let known_tilt = known.covariance.m11 + known.covariance.m22;
        // An estimator that a fault has just made start anew can be wrong by more than it says.
        let is_sound = self.tilt.aligned && !self.tilt.contradicts(&by, 0.5 * known_tilt);
        if known_tilt >= tilt || !is_sound {
            return;
        }
        // The field that the filter read since the mark may give the heading better.
        if known.covariance.m33 < state.errors.variance(HEADING) {
            heading.settle();
            state.propagation.turn(&by);
            state.errors.reset_attitude(&known.covariance);
            state.consistency = Consistency::new();
        } else {
            state.propagation.turn(&without_twist(&by));
            state.errors.reset_tilt(&known.covariance);
            state.consistency.note_added([1.0, 0.0]);
        }
        state.bias_rad_s = Vector3::zeros();
        state.reset_bias(&settings.config);
        state.refresh_rotation();
        self.tilt.believe();
        self.stop();
        self.report.is_stale = true;
    }
}

/// Rotation without its turn about the vertical; half a turn about a horizontal axis is returned unchanged.
fn without_twist(by: &Quaternion<f32>) -> Quaternion<f32> {
    let square = by.w * by.w + by.k * by.k;
    if square < 1e-6 {
        return *by;
    }
    Quaternion::new(by.w, 0.0, 0.0, -by.k) * (1.0 / libm::sqrtf(square)) * by
}
