//! Temperature of the probe's inertial sensor during a run.

use std::f64::consts::TAU;

use serde::Deserialize;

use super::{
    error::ScenarioError,
    limits::{check, within},
};

/// A steady change over the run and a slow swing on top; written to the trace's `temp_c` without noise.
///
/// Typical: some tens of degrees from the surface to the bottom within an hour or two, and a few degrees up
/// and down within minutes as the flow of the mud changes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Temperature {
    /// At the start of the run, degrees Celsius. Default 25.
    pub start_c: f64,
    /// Temperature at the end of the run without the swing, degrees Celsius; linear in between. Default: as
    /// at the start.
    pub end_c: Option<f64>,
    /// Amplitude of the swing, a sine that begins at zero and rises (falls if negative), degrees Celsius.
    /// Default 0.
    pub swing_c: f64,
    /// Period of the swing, seconds. Default 300.
    pub swing_period_s: f64,
}

impl Default for Temperature {
    fn default() -> Self {
        Self { start_c: 25.0, end_c: None, swing_c: 0.0, swing_period_s: 300.0 }
    }
}

impl Temperature {
    /// The temperature at `t_s` of a run of `duration_s`, degrees Celsius.
    pub(super) fn at(&self, t_s: f64, duration_s: f64) -> f64 {
        let risen_c = self.end_c.map_or(0.0, |end_c| end_c - self.start_c) * (t_s / duration_s);
        self.start_c + risen_c + self.swing_c * libm::sin(TAU * t_s / self.swing_period_s)
    }

    /// Checks every value.
    pub(super) fn validate(&self) -> Result<(), ScenarioError> {
        check(within(self.start_c, -100.0, 300.0), "temperature.start_c", "-100 to 300")?;
        check(self.end_c.is_none_or(|x| within(x, -100.0, 300.0)), "temperature.end_c", "-100 to 300")?;
        check(within(self.swing_c, -100.0, 100.0), "temperature.swing_c", "-100 to 100")?;
        check(within(self.swing_period_s, 0.1, 86_400.0), "temperature.swing_period_s", "0.1 to 86400")
    }
}

#[cfg(test)]
mod tests {
    use meerkat_mwd::SampleFlags;

    use super::*;
    use crate::simulate::{Scenario, simulate};

    #[test]
    fn it_goes_from_start_to_end_swings_in_between_and_is_written_to_the_trace() {
        let temperature = Temperature { start_c: 20.0, end_c: Some(60.0), swing_c: 3.0, swing_period_s: 8.0 };
        // A quarter of the swing's period in, three quarters, and two and a half periods.
        for (t_s, expected_c) in [(0.0, 20.0), (2.0, 20.0 + 4.0 + 3.0), (6.0, 20.0 + 12.0 - 3.0), (20.0, 60.0)] {
            assert!((temperature.at(t_s, 20.0) - expected_c).abs() < 1e-9);
        }
        let scenario = Scenario { duration_s: 20.0, temperature: Some(temperature), ..Scenario::default() };
        let warm = simulate(&scenario, 1).0.samples;
        assert!(warm.iter().all(|sample| !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING)));
        assert!((f64::from(warm[200].temperature_c) - 27.0).abs() < 1e-5);
        let unknown = simulate(&Scenario { temperature: None, ..scenario }, 1).0.samples;
        assert!(unknown.iter().all(|sample| sample.flags.contains(SampleFlags::TEMPERATURE_MISSING)));
        assert!(warm.iter().zip(&unknown).all(|(a, b)| a.gyro_rad_s == b.gyro_rad_s && a.mag_ut == b.mag_ut));
    }

    #[test]
    fn a_constant_needs_its_start_only() {
        let temperature = Temperature { start_c: 80.0, ..Temperature::default() };
        assert!([0.0, 7.0, 20.0].iter().all(|&t_s| (temperature.at(t_s, 20.0) - 80.0).abs() < 1e-12));
    }
}
