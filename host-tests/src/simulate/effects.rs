//! What real sensors have beside the gyro's twelve errors and noise. All of it is off by default.

use std::collections::VecDeque;

use meerkat_mwd::{Sample, SampleFlags};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::{
    random::Random,
    scenario::ScenarioError,
    sensors::{Ideal, matrix},
    vibration::STANDARD_GRAVITY_M_S2,
};

/// Effects on what the sensors sense, tool axes. A reading is `(I + matrix) v(t - lag) + offset`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Effects {
    /// Soft iron and misalignment of the magnetometer, row by row, added to the identity. Default zero.
    pub mag_matrix: [[f64; 3]; 3],
    /// Hard iron, microtesla. Default zero.
    pub hard_iron_ut: [f64; 3],
    /// Delay of the magnetometer, milliseconds. Default 0.
    pub mag_lag_ms: f64,
    /// Magnetic disturbances, as joints of a casing make them.
    pub magnetic_bursts: MagneticBursts,
    /// Scale factors and misalignment of the accelerometer, row by row, added to the identity. Default zero.
    pub accel_matrix: [[f64; 3]; 3],
    /// Zero offset of the accelerometer, m/s^2. Default zero.
    pub accel_bias_m_s2: [f64; 3],
    /// What the gyro reads of specific force, deg/s per g, row by row. Default zero.
    pub g_sensitivity_deg_s_g: [[f64; 3]; 3],
    /// Delay of the gyro, milliseconds. Default 0.
    pub gyro_lag_ms: f64,
    /// A step of the gyro's bias, deg/s. Default zero.
    pub bias_step_deg_s: [f64; 3],
    /// The step comes with the first shock after this time, seconds; where no shock follows, at this time. Default 0.
    pub bias_step_after_s: f64,
    /// Times without a reading of one sensor.
    pub dropouts: Dropouts,
}

/// Disturbances of the field at random (Poisson) instants: fixed in the earth, half a sine in time.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagneticBursts {
    /// Mean number in a minute. Default 0.
    pub per_minute: f64,
    /// Length of each, seconds. Default 2.
    pub length_s: f64,
    /// Peak, in a random direction of the earth frame, microtesla. Default 10.
    pub peak_ut: f64,
}

/// Dropouts at random (Poisson) instants, each of one sensor drawn at random.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dropouts {
    /// Mean number in a minute. Default 0.
    pub per_minute: f64,
    /// Length of each, seconds. Default 0.1.
    pub length_s: f64,
}

impl Default for MagneticBursts {
    fn default() -> Self {
        Self { per_minute: 0.0, length_s: 2.0, peak_ut: 10.0 }
    }
}

impl Default for Dropouts {
    fn default() -> Self {
        Self { per_minute: 0.0, length_s: 0.1 }
    }
}

impl Effects {
    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ScenarioError::Field { field, must_be }) };
        let within = |x: f64, low: f64, high: f64| (low..=high).contains(&x);
        let all = |values: &[f64], limit: f64| values.iter().all(|&x| within(x, -limit, limit));
        check(all(self.mag_matrix.as_flattened(), 0.2), "effects.mag_matrix", "-0.2 to 0.2")?;
        check(all(&self.hard_iron_ut, 1e3), "effects.hard_iron_ut", "-1000 to 1000")?;
        check(within(self.mag_lag_ms, 0.0, 1e3), "effects.mag_lag_ms", "0 to 1000")?;
        check(within(self.magnetic_bursts.per_minute, 0.0, 600.0), "effects.magnetic_bursts.per_minute", "0 to 600")?;
        check(within(self.magnetic_bursts.length_s, 0.01, 600.0), "effects.magnetic_bursts.length_s", "0.01 to 600")?;
        check(within(self.magnetic_bursts.peak_ut, 0.0, 1e3), "effects.magnetic_bursts.peak_ut", "0 to 1000")?;
        check(all(self.accel_matrix.as_flattened(), 0.2), "effects.accel_matrix", "-0.2 to 0.2")?;
        check(all(&self.accel_bias_m_s2, 100.0), "effects.accel_bias_m_s2", "-100 to 100")?;
        check(all(self.g_sensitivity_deg_s_g.as_flattened(), 100.0), "effects.g_sensitivity_deg_s_g", "-100 to 100")?;
        check(within(self.gyro_lag_ms, 0.0, 1e3), "effects.gyro_lag_ms", "0 to 1000")?;
        check(all(&self.bias_step_deg_s, 100.0), "effects.bias_step_deg_s", "-100 to 100")?;
        check(within(self.bias_step_after_s, 0.0, 86_400.0), "effects.bias_step_after_s", "0 to 86400")?;
        check(within(self.dropouts.per_minute, 0.0, 600.0), "effects.dropouts.per_minute", "0 to 600")?;
        check(within(self.dropouts.length_s, 0.001, 600.0), "effects.dropouts.length_s", "0.001 to 600")
    }

    /// The step of the bias, rad/s.
    pub(super) fn bias_step_rad_s(&self) -> Vector3<f64> {
        Vector3::from(self.bias_step_deg_s.map(f64::to_radians))
    }
}

/// A disturbance of the field: beginning, seconds, and peak in the earth frame, microtesla.
type Burst = (f64, Vector3<f64>);

/// The effects of a run, sample by sample.
pub(super) struct Disturber<'a> {
    effects: &'a Effects,
    mag_matrix: Matrix3<f64>,
    accel_matrix: Matrix3<f64>,
    g_sensitivity_s_m: Matrix3<f64>,
    mag_delay: Delay,
    gyro_delay: Delay,
    bursts: Vec<Burst>,
    /// Beginning, and the flag of the sensor that is missing.
    dropouts: Vec<(f64, SampleFlags)>,
}

impl<'a> Disturber<'a> {
    pub(super) fn new(effects: &'a Effects, period_s: f64, duration_s: f64, random: &mut Random) -> Self {
        let bursts = instants(effects.magnetic_bursts.per_minute, duration_s, random)
            .into_iter()
            .map(|start_s| (start_s, Vector3::from(random.direction()) * effects.magnetic_bursts.peak_ut))
            .collect();
        let sensors = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        let dropouts = instants(effects.dropouts.per_minute, duration_s, random)
            .into_iter()
            .map(|start_s| (start_s, sensors[random.between(0.0, 3.0) as usize]))
            .collect();
        let degrees_a_g = matrix(effects.g_sensitivity_deg_s_g);
        Self {
            effects,
            mag_matrix: Matrix3::identity() + matrix(effects.mag_matrix),
            accel_matrix: Matrix3::identity() + matrix(effects.accel_matrix),
            g_sensitivity_s_m: degrees_a_g.map(|x| x.to_radians() / STANDARD_GRAVITY_M_S2),
            mag_delay: Delay::new(effects.mag_lag_ms * 1e-3 / period_s),
            gyro_delay: Delay::new(effects.gyro_lag_ms * 1e-3 / period_s),
            bursts,
            dropouts,
        }
    }

    /// The disturbance of the field at `t_s`, earth frame, microtesla.
    pub(super) fn burst_ut(&self, t_s: f64) -> Vector3<f64> {
        let length_s = self.effects.magnetic_bursts.length_s;
        let active = self.bursts.iter().filter(|(start_s, _)| (*start_s..start_s + length_s).contains(&t_s));
        active.map(|(start_s, peak)| peak * libm::sin(std::f64::consts::PI * (t_s - start_s) / length_s)).sum()
    }

    /// What the sensors sense instead of the truth, and what the gyro reads in addition, rad/s; once for each sample, in order.
    pub(super) fn sensed(&mut self, ideal: &Ideal) -> (Ideal, Vector3<f64>) {
        let effects = self.effects;
        let force = ideal.specific_force_m_s2;
        let sensed = Ideal {
            rate_rad_s: self.gyro_delay.next(ideal.rate_rad_s),
            specific_force_m_s2: self.accel_matrix * force + Vector3::from(effects.accel_bias_m_s2),
            field_ut: self.mag_matrix * self.mag_delay.next(ideal.field_ut) + Vector3::from(effects.hard_iron_ut),
        };
        (sensed, self.g_sensitivity_s_m * force)
    }

    /// Takes out the readings that drop out.
    pub(super) fn drop_out(&self, sample: &mut Sample) {
        let t_s = sample.t_us as f64 * 1e-6;
        let length_s = self.effects.dropouts.length_s;
        for (_, sensor) in self.dropouts.iter().filter(|(start_s, _)| (*start_s..start_s + length_s).contains(&t_s)) {
            sample.flags.insert(*sensor);
            match *sensor {
                SampleFlags::GYRO_MISSING => sample.gyro_rad_s = [0.0; 3],
                SampleFlags::ACCEL_MISSING => sample.accel_m_s2 = [0.0; 3],
                _ => sample.mag_ut = [0.0; 3],
            }
        }
    }
}

/// Random (Poisson) instants, in order of time.
fn instants(per_minute: f64, duration_s: f64, random: &mut Random) -> Vec<f64> {
    let mut found = Vec::new();
    if per_minute <= 0.0 {
        return found;
    }
    let mut t_s = 0.0;
    loop {
        t_s += 60.0 / per_minute * random.exponential();
        if t_s >= duration_s {
            return found;
        }
        found.push(t_s);
    }
}

/// A delay of any length: linear between the samples that surround it. A vector that turns by a in a sample loses up to a^2 / 8
/// of its length there and none of its direction.
struct Delay {
    /// Samples.
    lag: f64,
    history: VecDeque<Vector3<f64>>,
}

impl Delay {
    fn new(lag: f64) -> Self {
        Self { lag, history: VecDeque::new() }
    }

    fn next(&mut self, value: Vector3<f64>) -> Vector3<f64> {
        self.history.push_front(value);
        let whole = self.lag as usize;
        self.history.truncate(whole + 2);
        // Before the first sample everything stood as in it.
        let ago = |n: usize| self.history.get(n).or(self.history.back()).copied().unwrap_or(value);
        ago(whole).lerp(&ago(whole + 1), self.lag - whole as f64)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::simulate::{Gyro, Scenario, ShockSettings, simulate};

    const DURATION_S: f64 = 40.0;

    /// A run without noise and with a perfect gyro, with effects.
    fn readings(effects: Effects) -> Vec<Sample> {
        let mut scenario = Scenario { duration_s: DURATION_S, effects, ..Scenario::default() };
        scenario.gyro = Gyro {
            p: Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            bias_deg_s: Some([0.0; 3]),
            noise_deg_s_rthz: 0.0,
            bias_walk_deg_s_rts: 0.0,
            ..Gyro::default()
        };
        scenario.accel.noise_ug_rthz = 0.0;
        scenario.mag.noise_ut = 0.0;
        scenario.validate().unwrap();
        simulate(&scenario, 1).0.samples
    }

    fn vector(v: [f32; 3]) -> Vector3<f64> {
        Vector3::from(v.map(f64::from))
    }

    #[test]
    fn matrices_and_offsets_are_added_to_what_is_read() {
        let clean = readings(Effects::default());
        let matrix_of = [[0.01, 0.02, -0.01], [0.0, -0.03, 0.01], [0.02, 0.0, 0.005]];
        let dirty = readings(Effects {
            mag_matrix: matrix_of,
            hard_iron_ut: [5.0, -3.0, 20.0],
            accel_matrix: matrix_of,
            accel_bias_m_s2: [0.1, 0.0, -0.2],
            g_sensitivity_deg_s_g: [[0.1, 0.0, 0.0], [0.0, 0.0, -0.05], [0.0, 0.02, 0.0]],
            ..Effects::default()
        });
        for (clean, dirty) in
            clean.iter().zip(&dirty).filter(|(clean, _)| clean.flags == SampleFlags::TEMPERATURE_MISSING)
        {
            let (field, force) = (vector(clean.mag_ut), vector(clean.accel_m_s2));
            let expected = field + matrix(matrix_of) * field + Vector3::new(5.0, -3.0, 20.0);
            assert!((vector(dirty.mag_ut) - expected).norm() < 1e-4);
            if dirty.flags == SampleFlags::TEMPERATURE_MISSING {
                let expected = force + matrix(matrix_of) * force + Vector3::new(0.1, 0.0, -0.2);
                assert!((vector(dirty.accel_m_s2) - expected).norm() < 1e-3);
            }
            let more = (vector(dirty.gyro_rad_s) - vector(clean.gyro_rad_s)).map(f64::to_degrees);
            let g = force / STANDARD_GRAVITY_M_S2;
            assert!((more - Vector3::new(0.1 * g.x, -0.05 * g.z, 0.02 * g.y)).norm() < 1e-3);
        }
    }

    #[test]
    fn a_lag_of_whole_samples_moves_the_column_and_a_broken_one_lies_between() {
        let clean = readings(Effects::default());
        let late = readings(Effects { mag_lag_ms: 20.0, gyro_lag_ms: 5.0, ..Effects::default() });
        for i in 2..clean.len() {
            assert_eq!(late[i].mag_ut, clean[i - 2].mag_ut);
            let middle = 0.5 * (vector(clean[i].gyro_rad_s) + vector(clean[i - 1].gyro_rad_s));
            assert!((vector(late[i].gyro_rad_s) - middle).norm() < 1e-6);
        }
    }

    #[test]
    fn a_bias_steps_once_at_a_shock_and_the_truth_knows() {
        let scenario = Scenario {
            duration_s: DURATION_S,
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
    fn bursts_are_fixed_in_the_earth_and_dropouts_are_flagged_as_often_as_asked() {
        let bursts = MagneticBursts { per_minute: 30.0, length_s: 1.0, peak_ut: 12.0 };
        let effects = Effects { magnetic_bursts: bursts, ..Effects::default() };
        let disturber = Disturber::new(&effects, 0.01, 600.0, &mut Random::new(3));
        let starts: Vec<f64> = disturber.bursts.iter().map(|(start_s, _)| *start_s).collect();
        let alone = (1..starts.len() - 1).find(|&i| starts[i - 1] + 1.0 < starts[i] && starts[i] + 1.0 < starts[i + 1]);
        let (start_s, peak) = disturber.bursts[alone.unwrap()];
        assert!((peak.norm() - 12.0).abs() < 1e-9);
        assert!((disturber.burst_ut(start_s + 0.5) - peak).norm() < 1e-9, "the peak in the middle");
        assert!((disturber.burst_ut(start_s + 1.0 / 6.0) - 0.5 * peak).norm() < 1e-9, "half of it a sixth in");
        assert!((disturber.bursts.len() as f64 - 300.0).abs() < 4.0 * 300_f64.sqrt());

        let dropped =
            readings(Effects { dropouts: Dropouts { per_minute: 60.0, length_s: 0.1 }, ..Effects::default() });
        let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
        let count = dropped.iter().filter(|s| s.flags.intersects(missing)).count() as f64;
        // 40 of 0.1 s at 100 Hz.
        assert!((count - 400.0).abs() < 4.0 * 10.0 * 40_f64.sqrt(), "{count}");
        for sample in dropped.iter().filter(|s| s.flags.contains(SampleFlags::MAG_MISSING)) {
            assert_eq!(sample.mag_ut, [0.0; 3]);
        }
    }
}
