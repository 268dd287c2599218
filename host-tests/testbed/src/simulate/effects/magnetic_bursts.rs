//! Bursts: brief disturbances of the earth's field.

use nalgebra::Vector3;
use serde::Deserialize;

use super::poisson::instants;
use crate::simulate::{
    error::ScenarioError,
    limits::{check, within},
    random::Random,
};

/// Disturbances of the field at random (Poisson) instants: fixed in the earth, half a sine in time.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MagneticBursts {
    /// Mean number per minute. Default 0.
    pub per_minute: f64,
    /// Length of each, seconds. Default 2.
    pub length_s: f64,
    /// Peak, in a random direction of the earth frame, microtesla. Default 10.
    pub peak_ut: f64,
}

impl Default for MagneticBursts {
    fn default() -> Self {
        Self { per_minute: 0.0, length_s: 2.0, peak_ut: 10.0 }
    }
}

impl MagneticBursts {
    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        check(within(self.per_minute, 0.0, 600.0), "effects.magnetic_bursts.per_minute", "0 to 600")?;
        check(within(self.length_s, 0.01, 600.0), "effects.magnetic_bursts.length_s", "0.01 to 600")?;
        check(within(self.peak_ut, 0.0, 1e3), "effects.magnetic_bursts.peak_ut", "0 to 1000")
    }
}

/// The bursts of a run.
pub(super) struct Bursts {
    length_s: f64,
    /// Start of each, seconds, and its peak in the earth frame, microtesla.
    bursts: Vec<(f64, Vector3<f64>)>,
}

impl Bursts {
    pub(super) fn new(settings: &MagneticBursts, duration_s: f64, random: &mut Random) -> Self {
        let bursts = instants(settings.per_minute, duration_s, random)
            .into_iter()
            .map(|start_s| (start_s, Vector3::from(random.direction()) * settings.peak_ut))
            .collect();
        Self { length_s: settings.length_s, bursts }
    }

    /// The disturbance at `t_s`, earth frame, microtesla.
    pub(super) fn at(&self, t_s: f64) -> Vector3<f64> {
        let length_s = self.length_s;
        let active = self.bursts.iter().filter(|(start_s, _)| (*start_s..start_s + length_s).contains(&t_s));
        active.map(|(start_s, peak)| peak * libm::sin(std::f64::consts::PI * (t_s - start_s) / length_s)).sum()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn bursts_are_as_many_as_asked_and_half_a_sine_in_time() {
        let settings = MagneticBursts { per_minute: 30.0, length_s: 1.0, peak_ut: 12.0 };
        let bursts = Bursts::new(&settings, 600.0, &mut Random::new(3));
        let starts: Vec<f64> = bursts.bursts.iter().map(|(start_s, _)| *start_s).collect();
        let alone = (1..starts.len() - 1).find(|&i| starts[i - 1] + 1.0 < starts[i] && starts[i] + 1.0 < starts[i + 1]);
        let (start_s, peak) = bursts.bursts[alone.unwrap()];
        assert!((peak.norm() - 12.0).abs() < 1e-9);
        assert!((bursts.at(start_s + 0.5) - peak).norm() < 1e-9, "the peak in the middle");
        assert!((bursts.at(start_s + 1.0 / 6.0) - 0.5 * peak).norm() < 1e-9, "half of it a sixth in");
        assert!((starts.len() as f64 - 300.0).abs() < 4.0 * 300_f64.sqrt());
    }
}
