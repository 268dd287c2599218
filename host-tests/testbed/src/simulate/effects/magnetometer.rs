//! Effects of the magnetometer on the field.

use nalgebra::{Matrix3, Vector3};

use super::{Effects, delay::Delay};
use crate::simulate::sensors::matrix;

pub(super) struct MagEffects<'a> {
    effects: &'a Effects,
    matrix: Matrix3<f64>,
    delay: Delay,
}

impl<'a> MagEffects<'a> {
    pub(super) fn new(effects: &'a Effects, period_s: f64) -> Self {
        Self {
            effects,
            matrix: Matrix3::identity() + matrix(effects.mag_matrix),
            delay: Delay::new(effects.mag_lag_ms, period_s),
        }
    }

    /// Field that the sensor senses at `t_s`, tool axes, in a tool that turns at this rate.
    pub(super) fn sensed(&mut self, t_s: f64, field_ut: Vector3<f64>, rate_rad_s: &Vector3<f64>) -> Vector3<f64> {
        // The collar's currents change the field around the sensor; the sensor's own errors and delay come
        // after.
        let eddy = Vector3::z().cross(&field_ut) * (self.effects.eddy_lag_ms * 1e-3 * rate_rad_s.z);
        let steel = self.matrix * self.delay.next(field_ut + eddy) + Vector3::from(self.effects.hard_iron_ut);
        // A magnet turns with the collar and induces no currents in it; it shares the sensor's delay.
        let sensed_s = t_s - self.effects.mag_lag_ms * 1e-3;
        steel + self.effects.hard_iron_intervals.iter().map(|magnet| magnet.at(sensed_s)).sum::<Vector3<f64>>()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::simulate::effects::clean_run::{STEADY, readings, samples, turning, vector};

    #[test]
    fn soft_and_hard_iron_are_added_to_what_is_read() {
        let mag_matrix = [[0.01, 0.02, -0.01], [0.0, -0.03, 0.01], [0.02, 0.0, 0.005]];
        let clean = readings(&Effects::default());
        let dirty = readings(&Effects { mag_matrix, hard_iron_ut: [5.0, -3.0, 20.0], ..Effects::default() });
        for (clean, dirty) in clean.iter().zip(&dirty) {
            let field = vector(clean.mag_ut);
            let expected = field + matrix(mag_matrix) * field + Vector3::new(5.0, -3.0, 20.0);
            assert!((vector(dirty.mag_ut) - expected).norm() < 1e-4);
        }
    }

    #[test]
    fn eddy_currents_turn_the_field_across_the_axis_by_the_arc_tangent_of_tau_w_and_leave_the_axial_one() {
        for (mean_rpm, rate_rad_s) in [(30.0, PI), (-60.0, -2.0 * PI)] {
            let clean = samples(&turning(&Effects::default(), mean_rpm));
            let eddied = samples(&turning(&Effects { eddy_lag_ms: 5.0, ..Effects::default() }, mean_rpm));
            for (clean, eddied) in clean.iter().zip(&eddied).skip(STEADY) {
                let (a, b) = (vector(clean.mag_ut), vector(eddied.mag_ut));
                let angle = (a.x * b.y - a.y * b.x).atan2(a.x * b.x + a.y * b.y);
                assert!((angle - (0.005 * rate_rad_s).atan()).abs() < 1e-6);
                assert_eq!(clean.mag_ut[2], eddied.mag_ut[2]);
            }
            // The field that is read is one of the past, as the sensor's own delay makes it.
            let late = samples(&turning(&Effects { mag_lag_ms: 5.0, ..Effects::default() }, mean_rpm));
            for (late, eddied) in late.iter().zip(&eddied).skip(STEADY) {
                assert!((vector(late.mag_ut) - vector(eddied.mag_ut)).norm() < 50.0 * (0.005 * rate_rad_s).powi(2));
            }
        }
    }
}
