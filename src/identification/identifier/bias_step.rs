//! What follows from a step of the gyro's bias that a diagnosis has found.

use super::{Identifier, theta_of};
use crate::diagnosis::BiasStepReport;
use nalgebra::Vector3;

impl Identifier {
    /// The new bias flies from here on, and all that was read or learnt before the step is moved by it, once. Returns whether it flies.
    #[inline(never)]
    pub(super) fn follow_step(&mut self, t_us: u64, step: &BiasStepReport, by_rad_s: &Vector3<f32>) -> bool {
        let Some(inverse) = self.flown.p_matrix().try_inverse() else { return false };
        let Some(b_rad_s) = step.bias_rad_s(&self.flown) else { return false };
        if !b_rad_s.iter().all(|b| b.is_finite()) {
            return false;
        }
        self.stream.step_bias(step.until, step.t_us, inverse * by_rad_s);
        self.carried.step_bias(step.t_us, by_rad_s);
        self.flown.b_rad_s = b_rad_s;
        self.stream.change_model(&theta_of(&self.flown));
        self.bias_known_us = t_us;
        true
    }
}
