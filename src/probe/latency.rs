//! Delays: the vector sensors' configured ones behind the gyro, and the uncertainty of the magnetometer's.

use super::Probe;
use crate::{compensation::effect::Sensor, sample::Reading};
use nalgebra::Vector3;

impl Probe {
    /// Turns calibrated specific force and field to the time at which the gyro's reading (raw, rad/s) was
    /// true.
    pub(super) fn at_gyro_time(&self, vectors: [Reading; 2], raw_rad_s: &Vector3<f32>, step_s: f32) -> [Reading; 2] {
        let [force_s, field_s] = self.config.latency.behind_gyro_s();
        if force_s == 0.0 && field_s == 0.0 {
            return vectors;
        }
        let rate = self.identifier.flown().compensate((*raw_rad_s).into());
        let acceleration = match self.session.last_rate_rad_s {
            Some(last) if step_s > 0.0 => (rate - last) / step_s,
            _ => Vector3::zeros(),
        };
        let rate = rate - self.filter.residual_bias_rad_s();
        let [force, field] = vectors;
        [(force, force_s), (field, field_s)].map(|(reading, behind_s)| match reading {
            Reading::Usable(v) => {
                // Rate at the middle of the delay.
                let turn = (rate - acceleration * (0.5 * behind_s)) * behind_s;
                Reading::Usable(later(&v, &turn))
            }
            other => other,
        })
    }

    /// Deviation of the magnetometer's known delay, seconds, beside the filter's own floor; `None`: the delay
    /// is unknown.
    pub(super) fn mag_delay_sigma_s(&self) -> Option<f32> {
        let configured = self.config.latency.mag_s.map(|_| 0.0);
        let found = self.effects().iter().find_map(|found| {
            let effect = self.library().get(usize::from(found.index))?;
            let of_field = effect.is_delay() && effect.sensor() == Sensor::Magnetometer;
            let of_gyro = effect.gyro_delay_s(&found.parameters) != 0.0;
            found.sigma.first().copied().filter(|_| of_field || of_gyro)
        });
        found.or(configured)
    }
}

/// Reading of an earth-fixed vector after the body has turned by a rotation vector, to second order: within
/// 6e-4 of its length at 0.15 rad (10 ms at 860 deg/s).
#[inline(never)]
fn later(v: &Vector3<f32>, turn_rad: &Vector3<f32>) -> Vector3<f32> {
    let halfway = v - turn_rad.cross(v) * 0.5;
    v - turn_rad.cross(&halfway)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::{exp_quaternion, rotate_back};

    #[test]
    fn a_vector_is_turned_as_the_body_turns() {
        let (v, turn) = (Vector3::new(20.0, -5.0, 45.0), Vector3::new(0.09, -0.12, 0.0));
        let exact = rotate_back(&exp_quaternion(&turn), &v);
        assert!((later(&v, &turn) - exact).norm() < 6e-4 * v.norm());
    }
}
