//! Changes of the gyro's bias beside its random walk: with a shock, with temperature and with time.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::Effects;
use crate::simulate::vibration::Shock;

/// Change of the gyro's bias at `t_s` and `warmer_c` above the temperature of the start, rad/s.
pub(super) fn bias_change_rad_s(effects: &Effects, t_s: f64, warmer_c: f64) -> Vector3<f64> {
    let with_temperature = Vector3::from(effects.gyro_bias_temperature_deg_s_c) * warmer_c;
    let amplitude = Vector3::from(effects.periodic_bias_deg_s);
    if amplitude == Vector3::zeros() {
        // Without an amplitude the period may be 0.
        return with_temperature.map(f64::to_radians);
    }
    let wave = libm::sin(TAU * t_s / effects.periodic_bias_period_s);
    (with_temperature + amplitude * wave).map(f64::to_radians)
}

/// Time of the bias step, seconds, and its size, rad/s.
pub(in crate::simulate) fn bias_step(effects: &Effects, shocks: &[Shock]) -> Option<(f64, Vector3<f64>)> {
    let after_s = effects.bias_step_after_s;
    let at_s = shocks.iter().map(|shock| shock.start_s).find(|start_s| *start_s >= after_s).unwrap_or(after_s);
    let step_rad_s = Vector3::from(effects.bias_step_deg_s.map(f64::to_radians));
    (step_rad_s != Vector3::zeros()).then_some((at_s, step_rad_s))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::simulate::{
        Gyro, Scenario, ShockSettings, Temperature,
        effects::clean_run::{drilling, turning, vector},
        simulate,
    };

    #[test]
    fn a_bias_steps_once_at_a_shock_and_the_truth_knows() {
        let scenario = Scenario {
            duration_s: 40.0,
            effects: Effects { bias_step_deg_s: [0.5, 0.0, -1.0], bias_step_after_s: 20.0, ..Effects::default() },
            gyro: Gyro { bias_walk_deg_s_rts: 0.0, ..Gyro::default() },
            ..Scenario::default()
        };
        let (trace, truth) = simulate(&scenario, 1);
        let shock = truth.shocks.iter().find(|shock| shock.start_s >= 20.0).unwrap();
        for (sample, bias) in trace.samples.iter().zip(&truth.bias_rad_s) {
            let stepped = vector(*bias) - vector(truth.gyro.b_rad_s);
            let expected = if sample.t_us as f64 * 1e-6 >= shock.start_s {
                Vector3::new(0.5, 0.0, -1.0)
            } else {
                Vector3::zeros()
            };
            assert!((stepped.map(f64::to_degrees) - expected).norm() < 1e-5);
        }
        let calm = Scenario { shocks: ShockSettings { per_minute: 0.0, ..ShockSettings::default() }, ..scenario };
        let (trace, truth) = simulate(&calm, 1);
        let stepped = truth.bias_rad_s.partition_point(|b| *b == truth.gyro.b_rad_s);
        assert_eq!(trace.samples[stepped].t_us, 20_000_000);
    }

    #[test]
    fn the_bias_follows_the_temperature_from_its_start_on_and_the_truth_knows() {
        let effects = Effects { gyro_bias_temperature_deg_s_c: [0.02, 0.0, -0.01], ..Effects::default() };
        // 30 deg C in 40 s.
        let temperature = Temperature { start_c: 50.0, end_c: Some(80.0), ..Temperature::default() };
        let (trace, truth) = simulate(&Scenario { temperature: Some(temperature), ..turning(&effects, 0.0) }, 1);
        for (sample, bias) in trace.samples.iter().zip(&truth.bias_rad_s) {
            let expected = Vector3::new(0.02, 0.0, -0.01) * (0.75 * sample.t_us as f64 * 1e-6);
            assert!((vector(sample.gyro_rad_s).map(f64::to_degrees) - expected).norm() < 1e-4);
            assert!((vector(*bias).map(f64::to_degrees) - expected).norm() < 1e-5);
            let by_its_column = Vector3::new(0.02, 0.0, -0.01) * (f64::from(sample.temperature_c) - 50.0);
            assert!((by_its_column - expected).norm() < 1e-6);
        }
    }

    #[test]
    fn a_periodic_bias_is_a_sine_that_begins_at_zero_and_the_truth_knows() {
        let effects =
            Effects { periodic_bias_deg_s: [0.2, 0.0, -0.4], periodic_bias_period_s: 8.0, ..Effects::default() };
        let (clean, _) = simulate(&drilling(&Effects::default()), 1);
        let (dirty, truth) = simulate(&drilling(&effects), 1);
        let amplitude = Vector3::new(0.2, 0.0, -0.4);
        for (i, share) in [(0, 0.0), (200, 1.0), (400, 0.0), (600, -1.0), (2_900, -(0.5_f64.sqrt())), (3_200, 0.0)] {
            let added = vector(dirty.samples[i].gyro_rad_s) - vector(clean.samples[i].gyro_rad_s);
            assert!((added.map(f64::to_degrees) - amplitude * share).norm() < 1e-3, "{i}");
            assert!((vector(truth.bias_rad_s[i]).map(f64::to_degrees) - amplitude * share).norm() < 1e-5, "{i}");
        }
    }
}
