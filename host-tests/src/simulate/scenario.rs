//! What is drilled, with what sensors: the TOML file that `cargo mwd simulate` reads.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{effects::Effects, temperature::Temperature};

/// A drilling run. Every field has a default, so an empty file is a scenario: 45 deg of inclination, 30 rpm with stick-slip.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scenario {
    /// Length of the run, seconds. Default 420.
    pub duration_s: f64,
    /// Sample period, microseconds. Default 10,000 (100 Hz).
    pub sample_period_us: u32,
    /// Steps of the internal truth in a sample period, even. Default 4.
    pub oversampling: u32,
    /// The tool stands still for so long before it drills, seconds. Default 10.
    pub rest_s: f64,
    /// From rest to full speed and vibration in so long, seconds. Default 3.
    pub ramp_s: f64,
    /// The hole.
    pub hole: Hole,
    /// Rotation about the tool axis.
    pub rotation: Rotation,
    /// Bending and whirl of the string: slow tilts of the tool axis about the hole's.
    pub wobble: Wobble,
    /// Vibration.
    pub vibration: Vibration,
    /// Shocks.
    pub shocks: ShockSettings,
    /// The earth at the probe.
    pub earth: EarthSettings,
    /// The gyro and its errors.
    pub gyro: Gyro,
    /// The accelerometer.
    pub accel: Accelerometer,
    /// The magnetometer.
    pub mag: Magnetometer,
    /// Temperature of the inertial sensor. Default: not given, and none in the trace.
    pub temperature: Option<Temperature>,
    /// What real sensors have beside all that. Default: nothing.
    pub effects: Effects,
}

/// Direction of the hole and how it changes. Azimuths count from magnetic north.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hole {
    /// Inclination where the run begins, degrees from the vertical. Default 45.
    pub inclination_deg: f64,
    /// Azimuth where the run begins, degrees. Default 60.
    pub azimuth_deg: f64,
    /// Change of inclination, degrees per hour of drilling. Default 3 (some 3 deg in 30 m at 30 m/h).
    pub build_rate_deg_h: f64,
    /// Change of azimuth, degrees per hour of drilling. Default 2.
    pub turn_rate_deg_h: f64,
}

/// Rotation about the tool axis.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rotation {
    /// Toolface at rest, degrees. Default 35.
    pub toolface_deg: f64,
    /// Mean speed, revolutions per minute. Default 30 (180 deg/s).
    pub mean_rpm: f64,
    /// Depth of stick-slip: at 1 the speed swings between 0 and twice the mean. It wanders down to 0.6 of this. Default 0.95.
    pub stick_slip: f64,
    /// Frequency of stick-slip, Hz; its phase wanders. Default 0.25.
    pub stick_slip_hz: f64,
}

/// Slow tilts of the tool axis, in two directions across the hole: they excite the lateral gyro axes as a real string does.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Wobble {
    /// Root mean square in each direction, degrees. Default 1.
    pub rms_deg: f64,
    /// Band, Hz. Default 0.1 to 0.5.
    pub band_hz: [f64; 2],
}

/// Vibration while drilling.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Vibration {
    /// Broadband lateral acceleration, m/s^2 rms of each of the two axes' readings (what aliases into them included). Default 3.
    pub lateral_m_s2: f64,
    /// Broadband axial acceleration, m/s^2 rms of the readings. Default 2.
    pub axial_m_s2: f64,
    /// The broadband part falls off below this frequency, Hz: a tool that stays in its hole has no slow acceleration. Default 2.
    pub lowest_hz: f64,
    /// Acceleration of the bit's chatter on every axis, amplitude at the mean speed, m/s^2; it goes with the square of the speed
    /// (a constant stroke, so that nothing is left of it where the bit sticks). Default 1.
    pub chatter_m_s2: f64,
    /// Strokes of the chatter in one revolution (cutters of the bit). Default 15: 7.5 Hz at 30 rpm.
    pub chatter_order: u32,
    /// Angular vibration about each axis, deg/s rms. Default 1.
    pub angular_deg_s: f64,
    /// Band of the angular vibration, Hz. Default 5 to 20.
    pub angular_band_hz: [f64; 2],
}

/// Shocks while drilling: half-sine pulses at random (Poisson) instants, mostly lateral.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShockSettings {
    /// Mean number in a minute. Default 20.
    pub per_minute: f64,
    /// Peak, uniform between these, in g (9.80665 m/s^2). Default 5 to 20.
    pub peak_g: [f64; 2],
    /// Length, uniform between these, milliseconds. Default 2 to 8.
    pub length_ms: [f64; 2],
    /// After a pulse a steady opposite acceleration of this length takes its velocity out again, milliseconds: a tool in a hole
    /// goes nowhere. 0: none. Default 50.
    pub rebound_ms: f64,
}

/// The earth at the probe.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EarthSettings {
    /// Gravity, m/s^2. Default 9.80665.
    pub gravity_m_s2: f64,
    /// Total magnetic field, microtesla. Default 50.
    pub magnetic_field_ut: f64,
    /// Magnetic dip, degrees below the horizontal. Default 65.
    pub dip_deg: f64,
    /// Geodetic latitude, degrees north. Given: the gyro senses the earth's rotation too. Default: not given.
    pub latitude_deg: Option<f64>,
    /// Magnetic declination, degrees east of true north; written to the trace. Default: not given.
    pub magnetic_declination_deg: Option<f64>,
}

/// The gyro: `raw = P^-1 w + b + noise`. Its 12 parameters are drawn, or given.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gyro {
    /// Standard deviation of P's diagonal about 1; no draw is nearer to 1 than half of it. Default 0.04.
    pub diagonal_sigma: f64,
    /// Standard deviation of P's off-diagonal; no draw is nearer to 0 than half of it. Default 0.02.
    pub off_diagonal_sigma: f64,
    /// Standard deviation of each axis of b, deg/s; no draw is nearer to 0 than half of it. Default 1.
    pub bias_sigma_deg_s: f64,
    /// P, row by row, instead of a draw.
    pub p: Option<[[f64; 3]; 3]>,
    /// b, deg/s, instead of a draw.
    pub bias_deg_s: Option<[f64; 3]>,
    /// White noise, deg/s per root hertz (angle random walk, deg per root second). Default 0.01.
    pub noise_deg_s_rthz: f64,
    /// Random walk of the bias, deg/s per root second. Default 0.001.
    pub bias_walk_deg_s_rts: f64,
    /// Step of the reading, deg/s. Default: none.
    pub resolution_deg_s: Option<f64>,
    /// Full scale, deg/s. Default 2,000.
    pub full_scale_deg_s: Option<f64>,
}

/// The accelerometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Accelerometer {
    /// White noise, micro-g per root hertz. Default 200.
    pub noise_ug_rthz: f64,
    /// Lever arm from the tool axis to the sensor, tool axes, metres: it adds w x (w x r) + w' x r. Default zero.
    pub lever_arm_m: [f64; 3],
    /// Step of the reading, m/s^2. Default: none.
    pub resolution_m_s2: Option<f64>,
    /// Full scale, g. Default 16.
    pub full_scale_g: Option<f64>,
}

/// The magnetometer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Magnetometer {
    /// White noise, microtesla rms of each reading. Default 0.2.
    pub noise_ut: f64,
    /// Step of the reading, microtesla. Default: none.
    pub resolution_ut: Option<f64>,
    /// Full scale, microtesla. Default: not given.
    pub full_scale_ut: Option<f64>,
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            duration_s: 420.0,
            sample_period_us: 10_000,
            oversampling: 4,
            rest_s: 10.0,
            ramp_s: 3.0,
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

impl Default for Hole {
    fn default() -> Self {
        Self { inclination_deg: 45.0, azimuth_deg: 60.0, build_rate_deg_h: 3.0, turn_rate_deg_h: 2.0 }
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self { toolface_deg: 35.0, mean_rpm: 30.0, stick_slip: 0.95, stick_slip_hz: 0.25 }
    }
}

impl Default for Wobble {
    fn default() -> Self {
        Self { rms_deg: 1.0, band_hz: [0.1, 0.5] }
    }
}

impl Default for Vibration {
    fn default() -> Self {
        Self {
            lateral_m_s2: 3.0,
            axial_m_s2: 2.0,
            lowest_hz: 2.0,
            chatter_m_s2: 1.0,
            chatter_order: 15,
            angular_deg_s: 1.0,
            angular_band_hz: [5.0, 20.0],
        }
    }
}

impl Default for ShockSettings {
    fn default() -> Self {
        Self { per_minute: 20.0, peak_g: [5.0, 20.0], length_ms: [2.0, 8.0], rebound_ms: 50.0 }
    }
}

impl Default for EarthSettings {
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.806_65,
            magnetic_field_ut: 50.0,
            dip_deg: 65.0,
            latitude_deg: None,
            magnetic_declination_deg: None,
        }
    }
}

impl Default for Gyro {
    fn default() -> Self {
        Self {
            diagonal_sigma: 0.04,
            off_diagonal_sigma: 0.02,
            bias_sigma_deg_s: 1.0,
            p: None,
            bias_deg_s: None,
            noise_deg_s_rthz: 0.01,
            bias_walk_deg_s_rts: 0.001,
            resolution_deg_s: None,
            full_scale_deg_s: Some(2000.0),
        }
    }
}

impl Default for Accelerometer {
    fn default() -> Self {
        Self { noise_ug_rthz: 200.0, lever_arm_m: [0.0; 3], resolution_m_s2: None, full_scale_g: Some(16.0) }
    }
}

impl Default for Magnetometer {
    fn default() -> Self {
        Self { noise_ut: 0.2, resolution_ut: None, full_scale_ut: None }
    }
}

/// Why a scenario cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML, or holds a field that no scenario has.
    #[error("{}: {source}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        source: Box<toml::de::Error>,
    },
    /// A value cannot be used.
    #[error("scenario: {field} must be {must_be}")]
    Field {
        /// The field, with its table.
        field: &'static str,
        /// What it must be.
        must_be: &'static str,
    },
}

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// The file cannot be read or parsed, or a value cannot be used.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let read = |source| ScenarioError::Read { path: path.to_path_buf(), source };
        let parse = |source| ScenarioError::Parse { path: path.to_path_buf(), source: Box::new(source) };
        let scenario: Self = toml::from_str(&std::fs::read_to_string(path).map_err(read)?).map_err(parse)?;
        scenario.validate()?;
        Ok(scenario)
    }
}
