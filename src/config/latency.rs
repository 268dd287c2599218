//! Delays of the sensors' readings, from data sheets.

use super::ConfigError;

/// Longest delay that can be configured, seconds.
const LONGEST_S: f32 = 0.1;

/// Delays of the sensors' readings: the time by which a reading's truth precedes its sample's time, from
/// low-pass filters, conversion, bus and [`Combiner`](crate::sensors::Combiner). [`Latency::of_parts`]
/// derives them from data sheets. `None` means unknown, and is taken as no delay; the diagnosis then looks
/// for a vector sensor's delay behind the gyro.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Latency {
    /// Gyro, seconds. Outputs are valid this long before their sample. A gyro that reads the mean over the interval
    /// that its sample ends has half a sample period. With `None` that half period is assumed, because a low-pass
    /// suited to the sample rate delays by at least as much (MPU-9250 register map, DLPF: 5.9 ms with 41 Hz, 3.9 ms
    /// with 92 Hz, so 0.6 to 0.8 of the period at 100 and 200 Hz; BMI160 and LSM6DSO, a second-order low-pass at 0.4
    /// and 0.3 of the rate: 0.55 to 0.7). Attitude is then that of the sample's time, uncertain by half a period either
    /// way. A reading without delay, which only a simulation has, is declared by 0.
    pub gyro_s: Option<f32>,
    /// Accelerometer, seconds.
    pub accel_s: Option<f32>,
    /// Magnetometer, seconds, including the mean wait for its sample; taken as known to a millisecond.
    pub mag_s: Option<f32>,
}

impl Latency {
    /// All delays unknown: settings of a static before it is configured.
    pub(super) const UNSET: Self = Self { gyro_s: None, accel_s: None, mag_s: None };

    /// Delays of accelerometer and magnetometer behind the gyro, seconds; negative: ahead of it.
    pub(crate) fn behind_gyro_s(&self) -> [f32; 2] {
        let gyro_s = self.gyro_s.unwrap_or(0.0);
        [self.accel_s, self.mag_s].map(|delay| delay.map_or(0.0, |delay_s| delay_s - gyro_s))
    }

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        let fields =
            [(self.gyro_s, "latency.gyro_s"), (self.accel_s, "latency.accel_s"), (self.mag_s, "latency.mag_s")];
        for (delay, field) in fields {
            if delay.is_some_and(|s| !(0.0..=LONGEST_S).contains(&s)) {
                return Err(ConfigError { field, must_be: "0 to 0.1" });
            }
        }
        Ok(())
    }
}
