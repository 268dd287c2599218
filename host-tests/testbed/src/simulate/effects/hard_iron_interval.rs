//! Hard iron that is on the probe for some time only, as a magnet.

use nalgebra::Vector3;
use serde::Deserialize;

use crate::simulate::{
    error::ScenarioError,
    limits::{all_within, check, within},
    ramp::smooth_ramp,
};

/// Hard iron that comes and goes smoothly. Where intervals overlap, their offsets add.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HardIronInterval {
    /// Time at which half of it has come, seconds.
    pub from_s: f64,
    /// Time at which half of it has gone, seconds.
    pub to_s: f64,
    /// Full offset, tool axes, microtesla. Typical 5 to 30.
    pub offset_ut: [f64; 3],
    /// Duration of coming and of going, centred on its time, seconds. Default 0.3.
    #[serde(default = "ramp_s")]
    pub ramp_s: f64,
}

fn ramp_s() -> f64 {
    0.3
}

impl HardIronInterval {
    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        check(within(self.from_s, 0.0, 86_400.0), "effects.hard_iron_intervals.from_s", "0 to 86400")?;
        check(within(self.to_s, self.from_s, 1e5), "effects.hard_iron_intervals.to_s", "from_s to 100000")?;
        check(all_within(&self.offset_ut, 1e3), "effects.hard_iron_intervals.offset_ut", "-1000 to 1000")?;
        let reaches_all_of_it = within(self.ramp_s, 0.001, self.to_s - self.from_s);
        check(reaches_all_of_it, "effects.hard_iron_intervals.ramp_s", "0.001 to the length of the interval")
    }

    /// The offset at `t_s`, tool axes, microtesla.
    pub(super) fn at(&self, t_s: f64) -> Vector3<f64> {
        let passed = |edge_s: f64| smooth_ramp((t_s - edge_s) / self.ramp_s + 0.5).0;
        Vector3::from(self.offset_ut) * (passed(self.from_s) - passed(self.to_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::effects::{
        Effects,
        clean_run::{readings, vector},
    };

    #[test]
    fn it_is_there_between_its_times_and_half_there_at_them() {
        let offset_ut = [20.0, -10.0, 5.0];
        let magnet = HardIronInterval { from_s: 12.0, to_s: 25.0, offset_ut, ramp_s: 0.3 };
        let clean = readings(&Effects::default());
        let dirty =
            readings(&Effects { hard_iron_intervals: vec![magnet.clone(), magnet.clone()], ..Effects::default() });
        for (clean, dirty) in clean.iter().zip(&dirty) {
            let share = match clean.t_us {
                12_000_000 | 25_000_000 => 0.5,
                12_150_000..=24_850_000 => 1.0,
                ..=11_850_000 | 25_150_000.. => 0.0,
                _ => continue,
            };
            let added = vector(dirty.mag_ut) - vector(clean.mag_ut);
            assert!((added - Vector3::from(offset_ut) * 2.0 * share).norm() < 1e-4, "{added} at {}", clean.t_us);
        }
    }

    #[test]
    fn the_sensors_lag_delays_the_magnet_too() {
        let magnet = HardIronInterval { from_s: 12.0, to_s: 25.0, offset_ut: [20.0, -10.0, 5.0], ramp_s: 0.3 };
        let hard_iron_intervals = vec![magnet];
        let clean = readings(&Effects { hard_iron_intervals: hard_iron_intervals.clone(), ..Effects::default() });
        let late = readings(&Effects { hard_iron_intervals, mag_lag_ms: 20.0, ..Effects::default() });
        for i in 2..clean.len() {
            assert!((vector(late[i].mag_ut) - vector(clean[i - 2].mag_ut)).norm() < 1e-4);
        }
    }
}
