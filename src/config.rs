//! Everything a user can set, with units, defaults and where each default comes from.
//!
//! Configuration is apart from state: a [`Config`] is checked once by [`Config::validate`] and never changes while drilling.

mod latency;

pub use latency::Latency;

use crate::compensation::{GyroModel, VectorModel};

/// What the whole pipeline needs to know about the probe, its sensors and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Config {
    /// Nominal sample period, microseconds. Default 5,000 (200 Hz). A step over 3 periods is a gap.
    pub sample_period_us: u32,
    /// Seed of the population search. Same samples, configuration and seed: same bytes out.
    pub seed: u64,
    /// From this sample time on no new parameter is taken (hold-out); the last window closes early enough to land before it.
    pub freeze_at_us: Option<u64>,
    /// Whether effects beyond the gyro's twelve parameters are looked for and taken out: magnets that come and go. Default `true`.
    pub effects: bool,
    /// Full scales, for the detection of clipped readings.
    pub full_scale: FullScale,
    /// Factory gyro model: flown until an identification is accepted, and the centre of the prior.
    pub gyro: GyroModel,
    /// Accelerometer calibration.
    pub accel: VectorModel,
    /// Magnetometer calibration.
    pub mag: VectorModel,
    /// Known delays of the sensors' readings.
    pub latency: Latency,
    /// The earth at the probe.
    pub earth: Earth,
    /// The attitude filter.
    pub attitude: AttitudeConfig,
    /// The identification window and its search.
    pub identification: IdentificationConfig,
}

/// Full scales of the sensors; `None`: unknown, so clipping of that sensor cannot be known.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct FullScale {
    /// Gyro, rad/s.
    pub gyro_rad_s: Option<f32>,
    /// Accelerometer, m/s^2.
    pub accel_m_s2: Option<f32>,
    /// Magnetometer, microtesla.
    pub mag_ut: Option<f32>,
}

/// The earth at the probe. Fields that are `None` are unknown and nothing is assumed about them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Earth {
    /// Local gravity, m/s^2. Default 9.80665 (standard gravity, ISO 80000-3).
    pub gravity_m_s2: f32,
    /// Total magnetic field, microtesla.
    pub magnetic_field_ut: Option<f32>,
    /// Magnetic dip below the horizontal, radians.
    pub dip_rad: Option<f32>,
    /// Magnetic declination, radians east of true north. Given: azimuth is true; `None`: azimuth is magnetic.
    pub declination_rad: Option<f32>,
    /// Geodetic latitude, radians north. Given: the earth's rotation (15.04 deg/h) is removed from the gyro.
    pub latitude_rad: Option<f32>,
}

/// The attitude filter. Standard deviations are those of what is left after compensation and calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct AttitudeConfig {
    /// Angle random walk of the gyro, rad/s per root hertz. Default 1.75e-4 (0.01 deg/s/rtHz, a common MEMS data-sheet
    /// value: MPU-9250 PS section 3.1).
    pub gyro_noise_rad_s_rthz: f32,
    /// Scale factor and coupling error of the compensated gyro, dimensionless. Larger: vectors weigh more while the probe turns.
    /// Default 0.015: sensitivity within 3 % and cross-axis within 2 % (MPU-9250 PS section 3.1), each uniform, are 0.014 rms over the
    /// nine elements. An accepted P's own deviations take its place where they are smaller.
    pub gyro_scale_sigma: f32,
    /// Bias random walk, rad/s per root second. Default 2e-5: at this rate a bias wanders 0.02 deg/s in 5 minutes.
    pub gyro_bias_walk_rad_s_rts: f32,
    /// Standard deviation of the residual gyro bias at the start, rad/s; after a change of P the largest. Default 0.02 (1.2 deg/s).
    pub gyro_bias_sigma_rad_s: f32,
    /// Horizontal speed of the probe, m/s, the only thing assumed about its accelerations: they integrate to no more than
    /// this. Smaller: gravity is found faster, and long accelerations tilt it more. Default 0.5 (hand-held, tripping).
    pub velocity_sigma_m_s: f32,
    /// Constant error of the calibrated accelerometer, m/s^2; it cannot be observed and goes into the reported sigmas. Default
    /// 0.03 (3 mg).
    pub accel_sigma_m_s2: f32,
    /// Error of the calibrated field's direction, radians, correlated over some seconds of motion. Default 0.03.
    pub mag_sigma_rad: f32,
    /// Uncertainty of the magnetometer's delay against the gyro while it is not known, seconds. Default 0.015 (a 100 Hz magnetometer's
    /// conversion and hold). A delay that is configured or found leaves a hundredth of a second's hold, uniform.
    pub mag_timing_sigma_s: f32,
    /// A total field that differs from the reference by more than this part is disturbed and not used. Default 0.1.
    pub mag_norm_tolerance: f32,
    /// A dip that differs from the reference by more than this is disturbed and not used, radians. Default 7 deg.
    pub mag_dip_tolerance_rad: f32,
    /// Below this inclination azimuth and gravity toolface are singular and the near-vertical toolface is reported, radians.
    /// Default 5 deg.
    pub near_vertical_rad: f32,
    /// Hysteresis of that limit, radians. Default 0.5 deg.
    pub near_vertical_hysteresis_rad: f32,
}

/// How the population search, or what takes its place, is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum OptimizerKind {
    /// Improved meerkat optimisation algorithm (the paper's, in our reading, whitened).
    #[default]
    Imoa,
    /// The same equations as printed; a baseline.
    ImoaLiteral,
    /// Meerkat optimisation algorithm; a baseline.
    Moa,
    /// Particle swarm with constriction.
    Pso,
    /// Differential evolution, DE/rand/1/bin.
    De,
    /// Random search; the floor of every comparison.
    Random,
    /// Levenberg-Marquardt.
    Lm,
    /// The closed-form least-squares point itself; no search.
    Ls,
}

/// The identification window, its prior, its search and its gate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct IdentificationConfig {
    /// Length of a window, seconds. Default 50 (the rate error falls as 0.12, 0.039, 0.026, 0.018 deg/s at 10, 25, 50, 100 s).
    pub window_s: f32,
    /// From the close of one window to the next, seconds. Default 25.
    pub step_s: f32,
    /// The shortest window that is identified, seconds. Default 20.
    pub min_window_s: f32,
    /// A window's result takes effect this long after the window closed, seconds. Default 5.
    pub latency_s: f32,
    /// Prior standard deviation of P's diagonal about the factory's. Default 0.06.
    pub prior_sigma_diagonal: f32,
    /// Prior standard deviation of P's off-diagonal. Default 0.03.
    pub prior_sigma_off_diagonal: f32,
    /// Prior standard deviation of the bias, rad/s. Default 0.021 (1.2 deg/s).
    pub prior_sigma_bias_rad_s: f32,
    /// Time in which what earlier windows have taught falls to 1/e, seconds; it goes into a window's prior, as long as the window does
    /// not contradict it. Default 3,600.
    pub forgetting_s: f32,
    /// A second whose gyro deviates less than this on every axis is a candidate for rest, rad/s. Default 0.5 deg/s.
    pub rest_gyro_deviation_rad_s: f32,
    /// A mean rate above this is rotation, not bias, however steady, rad/s. Default 0.087 (5 deg/s: the zero-rate output that
    /// MEMS data sheets allow after soldering).
    pub max_bias_rad_s: f32,
    /// What searches.
    pub optimizer: OptimizerKind,
    /// Most cost evaluations of a search. Default 75, half as many again as IMOA needs from the least-squares point.
    pub max_evaluations: u32,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            sample_period_us: 5_000,
            seed: 1,
            freeze_at_us: None,
            effects: true,
            full_scale: FullScale::default(),
            gyro: GyroModel::IDENTITY,
            accel: VectorModel::IDENTITY,
            mag: VectorModel::IDENTITY,
            latency: Latency::default(),
            earth: Earth::default(),
            attitude: AttitudeConfig::default(),
            identification: IdentificationConfig::default(),
        }
    }
}

impl Default for Earth {
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.806_65,
            magnetic_field_ut: None,
            dip_rad: None,
            declination_rad: None,
            latitude_rad: None,
        }
    }
}

impl Earth {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self =
        Self { gravity_m_s2: 0.0, magnetic_field_ut: None, dip_rad: None, declination_rad: None, latitude_rad: None };
}

impl AttitudeConfig {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self {
        gyro_noise_rad_s_rthz: 0.0,
        gyro_scale_sigma: 0.0,
        gyro_bias_walk_rad_s_rts: 0.0,
        gyro_bias_sigma_rad_s: 0.0,
        velocity_sigma_m_s: 0.0,
        accel_sigma_m_s2: 0.0,
        mag_sigma_rad: 0.0,
        mag_timing_sigma_s: 0.0,
        mag_norm_tolerance: 0.0,
        mag_dip_tolerance_rad: 0.0,
        near_vertical_rad: 0.0,
        near_vertical_hysteresis_rad: 0.0,
    };
}

impl Default for AttitudeConfig {
    fn default() -> Self {
        Self {
            gyro_noise_rad_s_rthz: 1.75e-4,
            gyro_scale_sigma: 0.015,
            gyro_bias_walk_rad_s_rts: 2e-5,
            gyro_bias_sigma_rad_s: 0.02,
            velocity_sigma_m_s: 0.5,
            accel_sigma_m_s2: 0.03,
            mag_sigma_rad: 0.03,
            mag_timing_sigma_s: 0.015,
            mag_norm_tolerance: 0.1,
            mag_dip_tolerance_rad: 7.0_f32.to_radians(),
            near_vertical_rad: 5.0_f32.to_radians(),
            near_vertical_hysteresis_rad: 0.5_f32.to_radians(),
        }
    }
}

impl Default for IdentificationConfig {
    fn default() -> Self {
        Self {
            window_s: 50.0,
            step_s: 25.0,
            min_window_s: 20.0,
            latency_s: 5.0,
            prior_sigma_diagonal: 0.06,
            prior_sigma_off_diagonal: 0.03,
            prior_sigma_bias_rad_s: 0.021,
            forgetting_s: 3_600.0,
            rest_gyro_deviation_rad_s: 0.5_f32.to_radians(),
            max_bias_rad_s: 5.0_f32.to_radians(),
            optimizer: OptimizerKind::Imoa,
            max_evaluations: 75,
        }
    }
}

/// Why a [`Config`] cannot be used: the field, and what it must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ConfigError {
    /// The field's path, for instance `identification.window_s`.
    pub field: &'static str,
    /// What the field must be.
    pub must_be: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "configuration: {} must be {}", self.field, self.must_be)
    }
}

impl core::error::Error for ConfigError {}

impl Config {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self {
        sample_period_us: 0,
        seed: 0,
        freeze_at_us: None,
        effects: false,
        full_scale: FullScale { gyro_rad_s: None, accel_m_s2: None, mag_ut: None },
        gyro: GyroModel::UNSET,
        accel: VectorModel { matrix: [[0.0; 3]; 3], offset: [0.0; 3] },
        mag: VectorModel { matrix: [[0.0; 3]; 3], offset: [0.0; 3] },
        latency: Latency::UNSET,
        earth: Earth::UNSET,
        attitude: AttitudeConfig::UNSET,
        identification: IdentificationConfig::UNSET,
    };

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that cannot be used.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ConfigError { field, must_be }) };
        let positive = |x: f32| x.is_finite() && x > 0.0;
        let optional = |x: Option<f32>| x.is_none_or(f32::is_finite);
        let optional_positive = |x: Option<f32>| x.is_none_or(positive);
        check((100..=50_000).contains(&self.sample_period_us), "sample_period_us", "100 to 50000 (20 Hz to 10 kHz)")?;
        check(optional_positive(self.full_scale.gyro_rad_s), "full_scale.gyro_rad_s", "positive")?;
        check(optional_positive(self.full_scale.accel_m_s2), "full_scale.accel_m_s2", "positive")?;
        check(optional_positive(self.full_scale.mag_ut), "full_scale.mag_ut", "positive")?;
        check(self.gyro.is_valid(), "gyro", "finite with a positive determinant")?;
        check(self.accel.is_valid(), "accel", "finite with a positive determinant")?;
        check(self.mag.is_valid(), "mag", "finite with a positive determinant")?;
        let earth = &self.earth;
        check((9.0..=10.5).contains(&earth.gravity_m_s2), "earth.gravity_m_s2", "9.0 to 10.5")?;
        check(optional_positive(earth.magnetic_field_ut), "earth.magnetic_field_ut", "positive")?;
        check(optional(earth.dip_rad), "earth.dip_rad", "finite")?;
        check(optional(earth.declination_rad), "earth.declination_rad", "finite")?;
        check(optional(earth.latitude_rad), "earth.latitude_rad", "finite")?;
        self.latency.validate()?;
        self.attitude.validate()?;
        self.identification.validate()
    }
}

impl AttitudeConfig {
    fn validate(&self) -> Result<(), ConfigError> {
        let fields = [
            (self.gyro_noise_rad_s_rthz, "attitude.gyro_noise_rad_s_rthz"),
            (self.gyro_scale_sigma, "attitude.gyro_scale_sigma"),
            (self.gyro_bias_walk_rad_s_rts, "attitude.gyro_bias_walk_rad_s_rts"),
            (self.gyro_bias_sigma_rad_s, "attitude.gyro_bias_sigma_rad_s"),
            (self.velocity_sigma_m_s, "attitude.velocity_sigma_m_s"),
            (self.accel_sigma_m_s2, "attitude.accel_sigma_m_s2"),
            (self.mag_sigma_rad, "attitude.mag_sigma_rad"),
            (self.mag_timing_sigma_s, "attitude.mag_timing_sigma_s"),
            (self.mag_norm_tolerance, "attitude.mag_norm_tolerance"),
            (self.mag_dip_tolerance_rad, "attitude.mag_dip_tolerance_rad"),
            (self.near_vertical_rad, "attitude.near_vertical_rad"),
            (self.near_vertical_hysteresis_rad, "attitude.near_vertical_hysteresis_rad"),
        ];
        all_positive(&fields)?;
        if self.gyro_bias_walk_rad_s_rts > 1.0 {
            return Err(ConfigError { field: "attitude.gyro_bias_walk_rad_s_rts", must_be: "at most 1" });
        }
        Ok(())
    }
}

impl IdentificationConfig {
    /// All zero, for a static before its configuration.
    pub(crate) const UNSET: Self = Self {
        window_s: 0.0,
        step_s: 0.0,
        min_window_s: 0.0,
        latency_s: 0.0,
        prior_sigma_diagonal: 0.0,
        prior_sigma_off_diagonal: 0.0,
        prior_sigma_bias_rad_s: 0.0,
        forgetting_s: 0.0,
        rest_gyro_deviation_rad_s: 0.0,
        max_bias_rad_s: 0.0,
        optimizer: OptimizerKind::Imoa,
        max_evaluations: 0,
    };

    fn validate(&self) -> Result<(), ConfigError> {
        let fields = [
            (self.window_s, "identification.window_s"),
            (self.step_s, "identification.step_s"),
            (self.min_window_s, "identification.min_window_s"),
            (self.latency_s, "identification.latency_s"),
            (self.prior_sigma_diagonal, "identification.prior_sigma_diagonal"),
            (self.prior_sigma_off_diagonal, "identification.prior_sigma_off_diagonal"),
            (self.prior_sigma_bias_rad_s, "identification.prior_sigma_bias_rad_s"),
            (self.forgetting_s, "identification.forgetting_s"),
            (self.rest_gyro_deviation_rad_s, "identification.rest_gyro_deviation_rad_s"),
            (self.max_bias_rad_s, "identification.max_bias_rad_s"),
        ];
        all_positive(&fields)?;
        let check = |ok: bool, field, must_be| if ok { Ok(()) } else { Err(ConfigError { field, must_be }) };
        check(self.window_s <= 50.0, "identification.window_s", "at most 50, the capacity of the window")?;
        check(self.min_window_s >= 20.0, "identification.min_window_s", "at least 20")?;
        check(self.min_window_s <= self.window_s, "identification.min_window_s", "at most window_s")?;
        check(self.latency_s <= 5.0, "identification.latency_s", "at most 5, the capacity behind the window")?;
        check(self.step_s >= self.latency_s, "identification.step_s", "at least latency_s")?;
        check((1..=100_000).contains(&self.max_evaluations), "identification.max_evaluations", "1 to 100000")
    }
}

fn all_positive(fields: &[(f32, &'static str)]) -> Result<(), ConfigError> {
    for &(value, field) in fields {
        if !(value.is_finite() && value > 0.0) {
            return Err(ConfigError { field, must_be: "finite and positive" });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid_and_a_bad_field_is_named() {
        assert_eq!(Config::default().validate(), Ok(()));
        let mut config = Config::default();
        config.identification.step_s = 1.0;
        assert_eq!(config.validate().map_err(|e| e.field), Err("identification.step_s"));
        config = Config::default();
        config.gyro.p[0][0] = f32::NAN;
        assert_eq!(config.validate().map_err(|e| e.field), Err("gyro"));
        config = Config::default();
        config.latency.mag_s = Some(-0.001);
        assert_eq!(config.validate().map_err(|e| e.field), Err("latency.mag_s"));
    }
}
