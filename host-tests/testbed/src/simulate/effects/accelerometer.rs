//! Effects of the accelerometer on specific force.

use nalgebra::{Matrix3, Vector3};

use super::{Effects, delay::Delay};
use crate::simulate::sensors::matrix;

pub(super) struct AccelEffects {
    matrix: Matrix3<f64>,
    bias_m_s2: Vector3<f64>,
    delay: Delay,
}

impl AccelEffects {
    pub(super) fn new(effects: &Effects, period_s: f64) -> Self {
        Self {
            matrix: Matrix3::identity() + matrix(effects.accel_matrix),
            bias_m_s2: Vector3::from(effects.accel_bias_m_s2),
            delay: Delay::new(effects.accel_lag_ms, period_s),
        }
    }

    /// Specific force that the sensor senses, tool axes.
    pub(super) fn sensed(&mut self, specific_force_m_s2: Vector3<f64>) -> Vector3<f64> {
        self.matrix * self.delay.next(specific_force_m_s2) + self.bias_m_s2
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use meerkat_mwd::SampleFlags;

    use super::*;
    use crate::simulate::{
        Rotation, Scenario,
        effects::clean_run::{STEADY, readings, samples, turning, vector},
        simulate,
    };

    #[test]
    fn matrix_and_bias_are_added_to_what_is_read() {
        let accel_matrix = [[0.01, 0.02, -0.01], [0.0, -0.03, 0.01], [0.02, 0.0, 0.005]];
        let clean = readings(&Effects::default());
        let dirty = readings(&Effects { accel_matrix, accel_bias_m_s2: [0.1, 0.0, -0.2], ..Effects::default() });
        let whole = |flags: SampleFlags| flags == SampleFlags::TEMPERATURE_MISSING;
        for (clean, dirty) in clean.iter().zip(&dirty).filter(|(a, b)| whole(a.flags) && whole(b.flags)) {
            let force = vector(clean.accel_m_s2);
            let expected = force + matrix(accel_matrix) * force + Vector3::new(0.1, 0.0, -0.2);
            assert!((vector(dirty.accel_m_s2) - expected).norm() < 1e-3);
        }
    }

    #[test]
    fn a_lever_arm_pulls_inwards_with_the_square_of_the_rate_and_backwards_against_what_speeds_it_up() {
        let arm = Effects { lever_arm_mm: [50.0, 0.0, 300.0], ..Effects::default() };
        let added = |on: &Scenario| {
            let off = Scenario { effects: Effects::default(), ..on.clone() };
            let (on, off) = (samples(on), samples(&off));
            on.into_iter().zip(off).map(|(a, b)| vector(a.accel_m_s2) - vector(b.accel_m_s2)).collect::<Vec<_>>()
        };
        // -w^2 r; the part along the axis does nothing.
        for inwards in added(&turning(&arm, -120.0)).iter().skip(STEADY) {
            assert!((inwards - Vector3::new(-16.0 * PI * PI * 0.05, 0.0, 0.0)).norm() < 1e-3, "{inwards}");
        }
        // With stick-slip against the true rate's central difference; z' x (x r) = y r.
        let stick_slip = Rotation { stick_slip: 0.8, ..Rotation::default() };
        let scenario = Scenario { rotation: stick_slip, ..turning(&arm, 30.0) };
        let rate = simulate(&scenario, 1).0.true_rate.unwrap_or_default();
        let added = added(&scenario);
        for i in 1..rate.len() - 1 {
            let derivative = (rate[i + 1][2] - rate[i - 1][2]) / 0.02;
            let expected = Vector3::new(-rate[i][2] * rate[i][2] * 0.05, derivative * 0.05, 0.0);
            assert!((added[i] - expected).norm() < 2e-3, "{i}: {} {expected}", added[i]);
        }
    }
}
