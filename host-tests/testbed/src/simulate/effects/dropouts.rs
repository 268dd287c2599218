//! Dropouts: missing readings.

use meerkat_mwd::{Sample, SampleFlags};
use serde::Deserialize;

use super::poisson::instants;
use crate::simulate::{
    error::ScenarioError,
    limits::{check, within},
    random::Random,
};

/// Dropouts at random (Poisson) instants, each of one sensor drawn at random.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dropouts {
    /// Mean number per minute. Default 0.
    pub per_minute: f64,
    /// Length of each, seconds. Default 0.1.
    pub length_s: f64,
}

impl Default for Dropouts {
    fn default() -> Self {
        Self { per_minute: 0.0, length_s: 0.1 }
    }
}

impl Dropouts {
    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        check(within(self.per_minute, 0.0, 600.0), "effects.dropouts.per_minute", "0 to 600")?;
        check(within(self.length_s, 0.001, 600.0), "effects.dropouts.length_s", "0.001 to 600")
    }
}

/// The dropouts of a run.
pub(super) struct DrawnDropouts {
    length_s: f64,
    /// Start of each, seconds, and the flag of the missing sensor.
    dropouts: Vec<(f64, SampleFlags)>,
}

impl DrawnDropouts {
    pub(super) fn new(settings: &Dropouts, duration_s: f64, random: &mut Random) -> Self {
        let sensors = [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        let dropouts = instants(settings.per_minute, duration_s, random)
            .into_iter()
            .map(|start_s| (start_s, sensors[random.between(0.0, 3.0) as usize]))
            .collect();
        Self { length_s: settings.length_s, dropouts }
    }

    /// Flags the readings that drop out as missing.
    pub(super) fn drop_out(&self, sample: &mut Sample) {
        let t_s = sample.t_us as f64 * 1e-6;
        let length_s = self.length_s;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::effects::{Effects, clean_run::readings};

    #[test]
    fn dropouts_are_flagged_as_often_as_asked() {
        let dropouts = Dropouts { per_minute: 60.0, length_s: 0.1 };
        let dropped = readings(&Effects { dropouts, ..Effects::default() });
        let missing = SampleFlags::GYRO_MISSING | SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
        let count = dropped.iter().filter(|s| s.flags.intersects(missing)).count() as f64;
        // 40 of 0.1 s at 100 Hz.
        assert!((count - 400.0).abs() < 4.0 * 10.0 * 40_f64.sqrt(), "{count}");
        for sample in dropped.iter().filter(|s| s.flags.contains(SampleFlags::MAG_MISSING)) {
            assert_eq!(sample.mag_ut, [0.0; 3]);
        }
    }
}
