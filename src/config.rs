//! Configuration: everything a user can set, with its unit, its default and the default's source.
//!
//! Configuration is apart from state: [`Config::validate`] checks a [`Config`] once, and the configuration never
//! changes while drilling.

mod attitude;
mod drilling_dynamics;
mod earth;
mod error;
mod full_scale;
mod identification;
mod latency;
mod motion;
mod optimizer_kind;
mod survey;
mod survey_errors;
mod survey_limits;
mod vector_errors;

pub use attitude::AttitudeConfig;
pub use drilling_dynamics::DynamicsConfig;
pub use earth::Earth;
pub use error::ConfigError;
pub use full_scale::FullScale;
pub use identification::IdentificationConfig;
pub use latency::Latency;
pub use motion::Motion;
pub use optimizer_kind::OptimizerKind;
pub use survey::SurveyConfig;
pub use survey_errors::SurveyErrors;
pub use survey_limits::SurveyLimits;
pub use vector_errors::VectorErrors;

use crate::compensation::{GyroModel, VectorModel};
use error::all_positive;
pub(crate) use error::check;

/// Configuration of the whole pipeline: the probe, its sensors and its place on the earth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Config {
    /// Nominal sample period, microseconds. Default 5,000 (200 Hz). A step over 3 periods is a gap.
    pub sample_period_us: u32,
    /// Seed of the population search. Equal samples, configuration and seed give equal bytes.
    pub seed: u64,
    /// Switches effects beyond the gyro's twelve parameters on: the library of effects, steps of the bias,
    /// and magnets that come and go. Default `true`.
    pub effects: bool,
    /// Full scales, to detect clipped readings.
    pub full_scale: FullScale,
    /// Factory gyro model: flown until another has been learnt, and the centre of P's prior.
    pub gyro: GyroModel,
    /// Accelerometer calibration.
    pub accel: VectorModel,
    /// Magnetometer calibration.
    pub mag: VectorModel,
    /// Known delays of the sensors' readings.
    pub latency: Latency,
    /// Earth at the probe: gravity, magnetic field, latitude.
    pub earth: Earth,
    /// Settings of the attitude filter.
    pub attitude: AttitudeConfig,
    /// Settings of the estimator of the gyro's errors, and of the search of each window.
    pub identification: IdentificationConfig,
    /// Settings of surveys, for [`Surveyor::configure`](crate::survey::Surveyor::configure).
    pub survey: SurveyConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            sample_period_us: 5_000,
            seed: 1,
            effects: true,
            full_scale: FullScale::default(),
            gyro: GyroModel::IDENTITY,
            accel: VectorModel::IDENTITY,
            mag: VectorModel::IDENTITY,
            latency: Latency::default(),
            earth: Earth::default(),
            attitude: AttitudeConfig::default(),
            identification: IdentificationConfig::default(),
            survey: SurveyConfig::default(),
        }
    }
}

impl Config {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self {
        sample_period_us: 0,
        seed: 0,
        effects: false,
        full_scale: FullScale { gyro_rad_s: None, accel_m_s2: None, mag_ut: None },
        gyro: GyroModel::UNSET,
        accel: VectorModel { matrix: [[0.0; 3]; 3], offset: [0.0; 3] },
        mag: VectorModel { matrix: [[0.0; 3]; 3], offset: [0.0; 3] },
        latency: Latency::UNSET,
        earth: Earth::UNSET,
        attitude: AttitudeConfig::UNSET,
        identification: IdentificationConfig::UNSET,
        survey: SurveyConfig::UNSET,
    };

    /// Checks every field.
    ///
    /// # Errors
    /// Names the first field that cannot be used.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let positive = |x: f32| x.is_finite() && x > 0.0;
        let optional_positive = |x: Option<f32>| x.is_none_or(positive);
        check((100..=50_000).contains(&self.sample_period_us), "sample_period_us", "100 to 50000 (20 Hz to 10 kHz)")?;
        check(optional_positive(self.full_scale.gyro_rad_s), "full_scale.gyro_rad_s", "positive")?;
        check(optional_positive(self.full_scale.accel_m_s2), "full_scale.accel_m_s2", "positive")?;
        check(optional_positive(self.full_scale.mag_ut), "full_scale.mag_ut", "positive")?;
        check(
            self.gyro.is_valid(),
            "gyro",
            "finite, with a positive determinant, elements of P below 1000 and P b below 1000 rad/s",
        )?;
        check(self.accel.is_valid(), "accel", "finite with a positive determinant")?;
        check(self.mag.is_valid(), "mag", "finite with a positive determinant")?;
        self.earth.validate()?;
        self.latency.validate()?;
        self.attitude.validate()?;
        self.identification.validate()?;
        self.survey.validate()
    }
}

/// Converts seconds to microseconds. Not inlined: a conversion to 64 bits takes as much code as a loop.
#[inline(never)]
pub(crate) fn micros(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}

#[cfg(test)]
mod tests;
