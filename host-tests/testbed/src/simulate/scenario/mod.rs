//! The scenario: what is drilled, with what sensors. `cargo mwd simulate` reads it from a TOML file.

mod earth;
mod motion;
mod sensors;
mod shaking;

use std::path::Path;

use serde::Deserialize;

use super::{effects::Effects, error::ScenarioError, temperature::Temperature};

pub use earth::EarthSettings;
pub use motion::{Hole, Rotation, Wobble};
pub use sensors::{Accelerometer, Gyro, Magnetometer};
pub use shaking::{ShockSettings, Vibration};

/// A drilling run. Every field has a default, so an empty file is a scenario: 45 deg of inclination, 30 rpm
/// with stick-slip.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// Length of the run, seconds. Default 420.
    pub duration_s: f64,
    /// Sample period, microseconds. Default 10,000 (100 Hz).
    pub sample_period_us: u32,
    /// Steps of the simulated truth per sample period, even. Default 4.
    pub oversampling: u32,
    /// Rest before drilling, seconds. Default 10.
    pub rest_s: f64,
    /// Time from rest to full speed and vibration, seconds. Default 3.
    pub ramp_s: f64,
    /// Time at which the tool stands still again, seconds, as at a connection. Default: never.
    pub stop_s: Option<f64>,
    /// Direction of the hole.
    pub hole: Hole,
    /// Rotation about the tool axis.
    pub rotation: Rotation,
    /// Bending and whirl of the string: slow tilts of the tool axis about the hole's.
    pub wobble: Wobble,
    /// Vibration while drilling.
    pub vibration: Vibration,
    /// Shocks while drilling.
    pub shocks: ShockSettings,
    /// The earth at the probe.
    pub earth: EarthSettings,
    /// The gyro and its errors.
    pub gyro: Gyro,
    /// The accelerometer.
    pub accel: Accelerometer,
    /// The magnetometer.
    pub mag: Magnetometer,
    /// Temperature of the inertial sensor. Default: none, and no column in the trace.
    pub temperature: Option<Temperature>,
    /// Further errors of real sensors. Default: none.
    pub effects: Effects,
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            duration_s: 420.0,
            sample_period_us: 10_000,
            oversampling: 4,
            rest_s: 10.0,
            ramp_s: 3.0,
            stop_s: None,
            hole: Hole::default(),
            rotation: Rotation::default(),
            wobble: Wobble::default(),
            vibration: Vibration::default(),
            shocks: ShockSettings::default(),
            earth: EarthSettings::default(),
            gyro: Gyro::default(),
            accel: Accelerometer::default(),
            mag: Magnetometer::default(),
            temperature: None,
            effects: Effects::default(),
        }
    }
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// The file cannot be read or parsed, or a value cannot be used.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let read = |source| ScenarioError::Read { path: path.to_path_buf(), source };
        let parse = |source| ScenarioError::Parse { path: path.to_path_buf(), source: Box::new(source) };
        let scenario: Self = toml::from_str(&crate::console::text(path).map_err(read)?).map_err(parse)?;
        scenario.validate()?;
        Ok(scenario)
    }
}
