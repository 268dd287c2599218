//! Observability of an effect: whether what was drawn can be seen and matters, by the truth and its noise
//! alone.
//!
//! The effect's readings are the difference of two runs, with it and without, that have all else in common.
//! The part that neither attitude, P and bias nor strengths and angle of gravity and field explain, over the
//! noise, is the square of the effect's size over its Cramer-Rao deviation: the sum of squared innovations of
//! a Kalman filter that reads only this difference.

use std::f64::consts::PI;

use meerkat_mwd::{Sample, config::IdentificationConfig};
use nalgebra::{Matrix3, Matrix3x4, Quaternion, UnitQuaternion, Vector3};

use super::trial::{DATA_S, held_out_too};
use testbed::simulate::{Effects, Scenario, sensors::SensorNoise, simulate, vibration::HighPassed};
use testbed::study::cramer_rao::{
    error_state::{C, ErrorState, VectorSensor},
    prior_sigmas,
};

/// Turn of a vector below which an effect does not matter, degrees.
const LEAST_TURN_DEG: f64 = 0.3;

/// Turn of the body in a second below which an effect does not matter, degrees.
const LEAST_DRIFT_DEG: f64 = 0.05;

/// Length of a test window, seconds; below it the step from one to the next.
const TEST_S: f64 = 2.0;
const HOP_S: f64 = 0.5;

/// Evidence beyond the cost of its parameters from which a candidate counts.
const LEAST_WORTH: f64 = 3.0;

/// Normal deviate with a chance of 1 % over the 20 candidates.
const CHANCE: f64 = 3.29;

/// Observability of an effect in a run.
pub(super) struct Observability {
    /// True if it turns vectors or body by more than is tolerated.
    pub(super) matters: bool,
    /// Square of its size over its deviation.
    pub(super) squared: f64,
}

impl Observability {
    /// Returns true if an effect with this many parameters can be expected to be named.
    pub(super) fn is_expected(&self, parameters: usize) -> bool {
        let k = parameters as f64;
        // Chi-square by Wilson and Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684.
        let spread = 2.0 / (9.0 * k);
        let by_chance = k * (1.0 - spread + CHANCE * spread.sqrt()).powi(3);
        // Cost of the parameters by Schwarz's criterion.
        let worth = 2.0 * LEAST_WORTH + k * (DATA_S / HOP_S).ln();
        self.matters && self.squared + k > by_chance.max(worth)
    }

    /// The observability of all effects of a run together.
    pub(super) fn of(drilled: &Scenario, seed: u64) -> Self {
        let scenario = &held_out_too(drilled);
        let clean = Scenario { effects: Effects::default(), ..scenario.clone() };
        let (trace, truth) = simulate(&clean, seed);
        let added = Added::between(scenario, &clean, seed);
        let noise = SensorNoise::of(scenario);
        let vibration = HighPassed::of(scenario);
        let p = truth.gyro.p_matrix().map(f64::from);
        let inverse = p.try_inverse().unwrap_or_else(Matrix3::identity);
        let period_s = f64::from(scenario.sample_period_us) * 1e-6;
        let (sine, cosine) = scenario.earth.dip_deg.to_radians().sin_cos();
        let field_ut = Vector3::new(cosine, 0.0, sine) * scenario.earth.magnetic_field_ut;
        let dipped_ut = Vector3::new(-sine, 0.0, cosine) * scenario.earth.magnetic_field_ut;
        let force_m_s2 = Vector3::new(0.0, 0.0, -scenario.earth.gravity_m_s2);

        // Four sets of readings: the effect's; stronger gravity; stronger field; a field that dips less.
        let mut filter: ErrorState<4> = ErrorState::new(&prior_sigmas(&IdentificationConfig::default()));
        let four = |columns: [Vector3<f64>; 4]| Matrix3x4::from_columns(&columns);
        let none = Vector3::zeros();
        let mut turned = Turned::default();
        let mut still_before = false;
        let rates = trace.true_rate.as_deref().unwrap_or_default().iter().zip(&trace.reference);
        for (index, (rate, q)) in rates.enumerate().take((DATA_S / period_s) as usize) {
            let (Some([w, x, y, z]), Some([more_rate, more_force, more_field])) = (*q, added.at(index)) else {
                continue;
            };
            let attitude = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let t_s = index as f64 * period_s;
            let still = t_s + 0.5 * period_s <= scenario.rest_s;
            let bias = Vector3::from(truth.gyro_at(index).b_rad_s.map(f64::from));
            let rate = Vector3::from(*rate);
            let more_rate = p * more_rate;
            let read = four([more_rate, none, none, none]);
            if index > 0 && !(still && still_before) {
                filter.turn(&rate, &(inverse * rate + bias), &read, period_s);
                filter.add_noise(0, &(p * p.transpose() * (noise.gyro_rad_s * period_s).powi(2)));
            }
            if still {
                filter.observe_rest(&inverse, &bias, &read, noise.gyro_rad_s);
            }
            let drilling = scenario.drilling_at(t_s).0;
            let shaken = vibration.scale_m_s2 * (drilling * (1.0 - vibration.smoothing));
            let [force, field, dipped] = [force_m_s2, field_ut, dipped_ut].map(|v| attitude.inverse() * v);
            let read = four([more_force, force, none, none]);
            filter.observe_vector(
                (VectorSensor::Accelerometer, &rate),
                &force,
                &read,
                &shaken,
                &Vector3::repeat(noise.accel_m_s2),
            );
            let read = four([more_field, none, field, dipped]);
            filter.observe_vector(
                (VectorSensor::Magnetometer, &rate),
                &field,
                &read,
                &none,
                &Vector3::repeat(noise.mag_ut),
            );
            filter.add_noise(C, &(p * p.transpose() * noise.bias_step_rad_s.powi(2)));
            filter.next_vibration(vibration.smoothing);
            still_before = still;
            if drilling > 0.0 {
                turned.rates.push((attitude, more_rate));
                for (turned, (more, vector)) in
                    turned.vectors.iter_mut().zip([(more_force, force), (more_field, field)])
                {
                    turned.push(more.norm_squared() / vector.norm_squared());
                }
            }
        }
        let common = filter.unexplained();
        let shared = common.fixed_view::<3, 1>(1, 0);
        let inverse = common.fixed_view::<3, 3>(1, 1).try_inverse().unwrap_or_else(Matrix3::zeros);
        let squared = common[(0, 0)] - (shared.transpose() * inverse * shared)[(0, 0)];
        Self { matters: turned.matters([force_m_s2, field_ut], period_s), squared }
    }
}

/// Readings that an effect adds to rate, specific force and field.
struct Added([Vec<Vector3<f64>>; 3]);

impl Added {
    fn between(scenario: &Scenario, clean: &Scenario, seed: u64) -> Self {
        let added = difference(scenario, clean, seed);
        if added.0[1].iter().all(|force| *force == Vector3::zeros()) {
            return added;
        }
        // Delayed vibration is still noise: take the difference in a run without vibration.
        let still = [scenario, clean].map(|scenario| {
            let mut still = scenario.clone();
            let vibration = &mut still.vibration;
            (vibration.lateral_m_s2, vibration.axial_m_s2, vibration.chatter_m_s2) = (0.0, 0.0, 0.0);
            still.shocks.per_minute = 0.0;
            still
        });
        let [rate, _, field] = added.0;
        let [_, force, _] = difference(&still[0], &still[1], seed).0;
        Self([rate, force, field])
    }

    fn at(&self, index: usize) -> Option<[Vector3<f64>; 3]> {
        let [rate, force, field] = &self.0;
        Some([*rate.get(index)?, *force.get(index)?, *field.get(index)?])
    }
}

fn difference(scenario: &Scenario, clean: &Scenario, seed: u64) -> Added {
    let [with, without] = [scenario, clean].map(|scenario| simulate(scenario, seed).0.samples);
    let of = |reading: fn(&Sample) -> [f32; 3]| {
        let vector = |sample: &Sample| Vector3::from(reading(sample)).cast::<f64>();
        with.iter().zip(&without).map(|(with, without)| vector(with) - vector(without)).collect()
    };
    Added([of(|sample| sample.gyro_rad_s), of(|sample| sample.accel_m_s2), of(|sample| sample.mag_ut)])
}

/// Angles that an effect turns while the tool drills.
#[derive(Default)]
struct Turned {
    /// Body to earth, and the added rate.
    rates: Vec<(UnitQuaternion<f64>, Vector3<f64>)>,
    /// Squares of the angles by which specific force and field can be turned.
    vectors: [Vec<f64>; 2],
}

impl Turned {
    fn matters(&self, earth: [Vector3<f64>; 2], period_s: f64) -> bool {
        let root_mean_square = |squares: &[f64]| (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        let vectors = self.vectors.iter().any(|squares| root_mean_square(squares) > LEAST_TURN_DEG.to_radians());
        // A constant in the body is a bias.
        let constant = self.rates.iter().map(|(_, rate)| rate).sum::<Vector3<f64>>() / self.rates.len().max(1) as f64;
        let length = (TEST_S / period_s) as usize;
        let weight = |k: usize| (PI * (k as f64 + 0.5) / length as f64).sin().powi(2) * period_s;
        let tests = self.rates.chunks_exact(length).map(|test| {
            let drift: Vector3<f64> =
                test.iter().enumerate().map(|(k, (attitude, rate))| attitude * (rate - constant) * weight(k)).sum();
            earth.map(|vector| vector.normalize().cross(&drift).norm_squared()).into_iter().fold(0.0, f64::max)
        });
        vectors || root_mean_square(&tests.collect::<Vec<f64>>()) > LEAST_DRIFT_DEG.to_radians()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::compensation::effects::LIBRARY;

    use super::*;
    use crate::bench::effects::trial::drilled;

    /// In a vertical hole the effect is a bias; in an inclined one it turns with the body. No effect gives
    /// zero, and twice the size gives four times the square.
    #[test]
    fn a_g_sensitivity_is_seen_where_gravity_turns_in_the_body_and_by_the_square_of_its_size() {
        let of = |inclination_deg: f64, size: f64| {
            let add = |scenario: &mut Scenario, _: &mut _| scenario.effects.g_sensitivity_deg_s_g = [[size; 3]; 3];
            Observability::of(&drilled(inclination_deg, 3, add).unwrap(), 3)
        };
        let (nothing, inclined, twice, vertical) = (of(45.0, 0.0), of(45.0, 0.1), of(45.0, 0.2), of(0.0, 0.1));
        assert!(!nothing.matters && nothing.squared.abs() < 1e-9, "{}", nothing.squared);
        assert!(inclined.is_expected(9) && !vertical.is_expected(9));
        assert!((twice.squared / inclined.squared - 4.0).abs() < 0.01, "{} {}", twice.squared, inclined.squared);
        assert_eq!(LIBRARY.len(), 20, "the chance is that of 20 candidates");
    }
}
