//! Effects of the gyro on the rate, and what it reads beside the rate.

use nalgebra::{Matrix3, Vector3};

use super::{Effects, delay::Delay};
use crate::simulate::{
    sensors::{Ideal, matrix},
    vibration::STANDARD_GRAVITY_M_S2,
};

pub(super) struct GyroEffects<'a> {
    effects: &'a Effects,
    /// rad/s per m/s^2.
    g_sensitivity_s_m: Matrix3<f64>,
    /// rad/s per (m/s^2)^2.
    rectification_s3_m2: Vector3<f64>,
    delay: Delay,
    period_s: f64,
}

impl<'a> GyroEffects<'a> {
    pub(super) fn new(effects: &'a Effects, period_s: f64) -> Self {
        let per_g = matrix(effects.g_sensitivity_deg_s_g);
        let per_g2 = Vector3::from(effects.vibration_rectification_deg_s_g2);
        Self {
            effects,
            g_sensitivity_s_m: per_g.map(|x| x.to_radians() / STANDARD_GRAVITY_M_S2),
            rectification_s3_m2: per_g2.map(f64::to_radians) / (STANDARD_GRAVITY_M_S2 * STANDARD_GRAVITY_M_S2),
            delay: Delay::new(effects.gyro_lag_ms, period_s),
            period_s,
        }
    }

    /// Rate that the sensor senses over the sample at `t_s`, in the axes in which it was mounted.
    pub(super) fn sensed(&mut self, t_s: f64, rate_rad_s: Vector3<f64>) -> Vector3<f64> {
        let rate_rad_s = self.effects.mount_rotation.as_ref().map_or(rate_rad_s, |mount| {
            // While the gyro turns in its mount, it senses that rotation too.
            let own_rad_s = mount.mean_rate_rad_s(t_s - 0.5 * self.period_s, t_s + 0.5 * self.period_s);
            mount.turn_at(t_s).inverse_transform_vector(&rate_rad_s) + own_rad_s
        });
        self.delay.next(rate_rad_s)
    }

    /// Additions to the reading at `t_s`, beside the scaled rate `P^-1 w` and the bias, rad/s.
    pub(super) fn additions_rad_s(&self, t_s: f64, ideal: &Ideal, scaled_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let force = ideal.specific_force_m_s2;
        let mount = self.effects.mount_rotation.as_ref();
        let in_its_axes = mount.map_or(force, |mount| mount.turn_at(t_s).inverse_transform_vector(&force));
        let accelerated_m_s2 = force + ideal.gravity_m_s2;
        let nonlinearity = Vector3::from(self.effects.gyro_scale_nonlinearity_s2_rad2);
        let asymmetry = Vector3::from(self.effects.gyro_scale_asymmetry);
        self.g_sensitivity_s_m * in_its_axes
            + self.rectification_s3_m2 * accelerated_m_s2.norm_squared()
            + nonlinearity.component_mul(&scaled_rad_s.map(|u| u * u * u))
            + asymmetry.component_mul(&scaled_rad_s.map(f64::abs))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::simulate::effects::{
        MountRotation,
        clean_run::{STEADY, readings, samples, turning, vector},
    };

    #[test]
    fn g_sensitivity_is_added_to_what_is_read() {
        let clean = readings(&Effects::default());
        let g_sensitivity_deg_s_g = [[0.1, 0.0, 0.0], [0.0, 0.0, -0.05], [0.0, 0.02, 0.0]];
        let dirty = readings(&Effects { g_sensitivity_deg_s_g, ..Effects::default() });
        let unclipped = clean.iter().zip(&dirty).filter(|(clean, _)| clean.accel_m_s2.iter().all(|x| x.abs() < 150.0));
        for (clean, dirty) in unclipped {
            let more = (vector(dirty.gyro_rad_s) - vector(clean.gyro_rad_s)).map(f64::to_degrees);
            let g = vector(clean.accel_m_s2) / STANDARD_GRAVITY_M_S2;
            assert!((more - Vector3::new(0.1 * g.x, -0.05 * g.z, 0.02 * g.y)).norm() < 1e-3);
        }
    }

    #[test]
    fn a_gyro_that_has_turned_feels_gravity_along_its_own_axes() {
        let g_sensitivity_deg_s_g = [[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        let mount = MountRotation { from_s: 1.0, rotation_deg: [0.0, 0.0, 90.0], ramp_s: 1.0 };
        let effects = Effects { g_sensitivity_deg_s_g, mount_rotation: Some(mount), ..Effects::default() };
        let at_rest = &samples(&turning(&effects, 30.0))[500];
        // Its x lies along the tool's y.
        let expected = f64::from(at_rest.accel_m_s2[1]) / STANDARD_GRAVITY_M_S2;
        assert!((f64::from(at_rest.gyro_rad_s[0]).to_degrees() - expected).abs() < 1e-5);
    }

    #[test]
    fn vibration_is_rectified_with_the_square_of_all_acceleration_but_not_of_gravity() {
        let vibration_rectification_deg_s_g2 = [0.02, 0.0, -0.01];
        // Nothing shakes here: 16 pi^2 0.05 m/s^2 towards the axis is all there is, and nothing of it at
        // rest.
        let lever_arm_mm = [0.0, 50.0, 0.0];
        let spun = Effects { vibration_rectification_deg_s_g2, lever_arm_mm, ..Effects::default() };
        let spun = samples(&turning(&spun, 120.0));
        let square = (16.0 * PI * PI * 0.05 / STANDARD_GRAVITY_M_S2).powi(2);
        for sample in spun.iter().skip(STEADY) {
            let read = vector(sample.gyro_rad_s).map(f64::to_degrees) - Vector3::new(0.0, 0.0, 720.0);
            assert!((read - Vector3::new(0.02, 0.0, -0.01) * square).norm() < 1e-4, "{read}");
        }
        assert!(spun.iter().take(999).all(|sample| vector(sample.gyro_rad_s).norm() < 1e-15));
        // While drilling it is what the accelerometer shows of it.
        let clean = readings(&Effects::default());
        let gravity = vector(clean[0].accel_m_s2).norm();
        let shaken = readings(&Effects { vibration_rectification_deg_s_g2, ..Effects::default() });
        let (mut rectified, mut seen, mut count) = (0.0, 0.0, 0.0);
        let unclipped = clean.iter().zip(&shaken).filter(|(clean, _)| clean.accel_m_s2.iter().all(|x| x.abs() < 150.0));
        for (clean, shaken) in unclipped.skip(STEADY) {
            rectified += f64::from(shaken.gyro_rad_s[0] - clean.gyro_rad_s[0]).to_degrees();
            seen += vector(clean.accel_m_s2).norm_squared() / STANDARD_GRAVITY_M_S2.powi(2);
            count += 1.0;
        }
        let expected = 0.02 * (seen / count - (gravity / STANDARD_GRAVITY_M_S2).powi(2));
        // Gravity and vibration are not correlated: |f|^2 = |a|^2 + g^2 in the mean.
        assert!((rectified / count / expected - 1.0).abs() < 0.05, "{} {expected}", rectified / count);
    }

    #[test]
    fn the_scale_is_cubic_and_lopsided_in_the_gyros_own_axes() {
        let gyro_scale_nonlinearity_s2_rad2 = [0.3e-3, 0.2e-3, -1e-3];
        let gyro_scale_asymmetry = [0.01, 0.0, 2e-3];
        for (mean_rpm, w) in [(30.0, PI), (-60.0, -2.0 * PI)] {
            for scale in [1.0, 0.5] {
                let effects = Effects { gyro_scale_nonlinearity_s2_rad2, gyro_scale_asymmetry, ..Effects::default() };
                let mut scenario = turning(&effects, mean_rpm);
                scenario.gyro.p = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, scale]]);
                let u = w / scale;
                let expected = u - 1e-3 * u * u * u + 2e-3 * u.abs();
                for sample in samples(&scenario).iter().skip(STEADY) {
                    assert!((vector(sample.gyro_rad_s) - Vector3::new(0.0, 0.0, expected)).norm() < 2e-6);
                }
            }
        }
    }
}
