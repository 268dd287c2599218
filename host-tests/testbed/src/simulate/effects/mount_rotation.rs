//! Turn of the gyro in its mount.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::Deserialize;

use crate::simulate::{
    error::ScenarioError,
    limits::{all_within, check, within},
    ramp::smooth_ramp,
};

/// The gyro turns smoothly against the tool and stays so; the other sensors do not turn.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MountRotation {
    /// Start of the turn, seconds.
    pub from_s: f64,
    /// The turn as a rotation vector, right-handed, tool axes, degrees. An axis e of the gyro lies along R e
    /// afterwards, so that `P^-1 R^T w` is read of the tool's rate w. Typical 0.5 to 5.
    pub rotation_deg: [f64; 3],
    /// Duration of the turn, seconds. Default 1.
    #[serde(default = "ramp_s")]
    pub ramp_s: f64,
}

fn ramp_s() -> f64 {
    1.0
}

impl MountRotation {
    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        check(within(self.from_s, 0.0, 86_400.0), "effects.mount_rotation.from_s", "0 to 86400")?;
        check(all_within(&self.rotation_deg, 180.0), "effects.mount_rotation.rotation_deg", "-180 to 180")?;
        check(within(self.ramp_s, 0.001, 86_400.0), "effects.mount_rotation.ramp_s", "0.001 to 86400")
    }

    /// Rotation from the gyro's axes to where they lay at the start.
    pub(in crate::simulate) fn turn_at(&self, t_s: f64) -> UnitQuaternion<f64> {
        let turned = self.vector_rad(t_s);
        let angle = turned.norm();
        if angle == 0.0 {
            return UnitQuaternion::identity();
        }
        let (sine, cosine) = libm::sincos(0.5 * angle);
        UnitQuaternion::new_unchecked(Quaternion::from_parts(cosine, turned * (sine / angle)))
    }

    /// Mean rate of the gyro against the tool over an interval, rad/s; the same in either's axes, because it
    /// turns about one axis.
    pub(super) fn mean_rate_rad_s(&self, from_s: f64, to_s: f64) -> Vector3<f64> {
        (self.vector_rad(to_s) - self.vector_rad(from_s)) / (to_s - from_s)
    }

    fn vector_rad(&self, t_s: f64) -> Vector3<f64> {
        Vector3::from(self.rotation_deg.map(f64::to_radians)) * smooth_ramp((t_s - self.from_s) / self.ramp_s).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::{
        Rotation, Scenario,
        effects::{
            Effects,
            clean_run::{drilling, samples, turning, vector},
        },
        simulate,
    };

    fn turned_by(rotation_deg: [f64; 3], from_s: f64) -> Effects {
        let mount_rotation = Some(MountRotation { from_s, rotation_deg, ramp_s: 0.5 });
        Effects { mount_rotation, ..Effects::default() }
    }

    #[test]
    fn a_gyro_that_has_turned_forward_about_x_sees_the_tools_z_on_its_y() {
        let quarter = samples(&turning(&turned_by([90.0, 0.0, 0.0], 5.0), 30.0));
        // Its y has gone to the tool's z, its z to minus the tool's y.
        let last = vector(quarter[quarter.len() - 1].gyro_rad_s).map(f64::to_degrees);
        assert!((last - Vector3::new(0.0, 180.0, 0.0)).norm() < 1e-3, "{last}");
        let turned = quarter.iter().take(1_000).map(|s| vector(s.gyro_rad_s)).sum::<Vector3<f64>>() * 0.01;
        assert!((turned.map(f64::to_degrees) - Vector3::new(90.0, 0.0, 0.0)).norm() < 1e-3, "its own turn: {turned}");
    }

    #[test]
    fn what_the_gyro_integrates_is_its_own_attitude() {
        let scenario = Scenario {
            rotation: Rotation { stick_slip: 0.5, ..Rotation::default() },
            ..drilling(&turned_by([3.0, -2.0, 4.0], 20.0))
        };
        let (trace, _) = simulate(&scenario, 1);
        let attitude = |i: usize| {
            let [w, x, y, z] = trace.reference[i].unwrap_or_default();
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
        };
        let (first, last) = (1_900, 2_200);
        let mut gyro = attitude(first);
        for i in first..last {
            let [a, b] = [i, i + 1].map(|i| vector(trace.samples[i].gyro_rad_s));
            gyro *= UnitQuaternion::from_scaled_axis((a + b) * 0.005 + a.cross(&b) * (1e-4 / 12.0));
        }
        let turned = (attitude(last).inverse() * gyro).scaled_axis().map(f64::to_degrees);
        assert!((turned - Vector3::new(3.0, -2.0, 4.0)).norm() < 0.02, "{turned}");
    }

    #[test]
    fn the_truth_turns_with_it() {
        let mut scenario = drilling(&turned_by([3.0, -2.0, 4.0], 20.0));
        scenario.gyro.p = None;
        scenario.gyro.bias_deg_s = None;
        let (trace, truth) = simulate(&scenario, 1);
        assert_eq!(truth.gyro_at(1_999), truth.gyro);
        let rates = trace.true_rate.unwrap_or_default();
        for i in (0..2_000).chain(2_051..rates.len()) {
            let model = truth.gyro_at(i);
            let corrected = model.p_matrix().map(f64::from) * vector(trace.samples[i].gyro_rad_s)
                - model.p_matrix().map(f64::from) * vector(model.b_rad_s);
            assert!((corrected - Vector3::from(rates[i])).norm() < 1e-5, "{i}");
        }
    }
}
