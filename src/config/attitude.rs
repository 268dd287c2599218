use super::{ConfigError, all_positive};

/// The attitude filter. Standard deviations are those of what is left after compensation and calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
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
    /// Bias random walk, rad/s per root second. Default 2e-5: at this rate a bias wanders 0.02 deg/s in 5 minutes, as one of 0.02 deg/s/K
    /// does that warms by a kelvin (LSM6DSO: 0.010, ICM-42688-P: 0.005 typical).
    pub gyro_bias_walk_rad_s_rts: f32,
    /// Standard deviation of the residual gyro bias at the start, rad/s; after a change of P the largest. Default 0.02 (1.2
    /// deg/s): the zero-rate output of data sheets, 1 deg/s typical for an LSM6DSO, with its change over temperature.
    pub gyro_bias_sigma_rad_s: f32,
    /// Horizontal speed of the probe, m/s, the only thing assumed about its accelerations: they integrate to no more than
    /// this. Smaller: gravity is found faster, and long accelerations tilt it more. Default 0.5: a hand that swings by a quarter of a metre to
    /// both sides every two seconds has 0.55 rms, and pipe is tripped at some 0.5.
    pub velocity_sigma_m_s: f32,
    /// Constant error of the calibrated accelerometer, m/s^2; it cannot be observed and goes into the reported sigmas. Default
    /// 0.03 (3 mg).
    pub accel_sigma_m_s2: f32,
    /// Error of the calibrated field's direction, radians, correlated over some seconds of motion. Default 0.03: a heading within 2.5 deg
    /// where the horizontal field is 30 microtesla (BMM150 data sheet, table 1), of a total of some 45.
    pub mag_sigma_rad: f32,
    /// Uncertainty of the magnetometer's delay against the gyro while it is not known, seconds. Default 0.015 (a 100 Hz magnetometer's
    /// conversion and hold). A delay that is configured or found leaves a millisecond. Beside it each reading is held for up to a
    /// hundredth of a second.
    pub mag_timing_sigma_s: f32,
    /// A total field that differs from the reference by more than this part is disturbed and not used. Default 0.1 (VQF's: Laidig and Seel,
    /// Information Fusion 91, 2023).
    pub mag_norm_tolerance: f32,
    /// A dip that differs from the reference by more than this is disturbed and not used, radians. Default 0.1: a disturbance as large across
    /// the field as the tolerance of the total field lets be along it. A field that is the same through 20 s of turning becomes the reference, in the
    /// place of a configured one too: that the dip is the configured one is for a survey to say.
    pub mag_dip_tolerance_rad: f32,
    /// Below this inclination azimuth and gravity toolface are singular and the near-vertical toolface is reported, radians.
    /// Default 5 deg.
    pub near_vertical_rad: f32,
    /// Hysteresis of that limit, radians. Default 0.5 deg.
    pub near_vertical_hysteresis_rad: f32,
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

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [
                self.gyro_noise_rad_s_rthz,
                self.gyro_scale_sigma,
                self.gyro_bias_walk_rad_s_rts,
                self.gyro_bias_sigma_rad_s,
                self.velocity_sigma_m_s,
                self.accel_sigma_m_s2,
                self.mag_sigma_rad,
                self.mag_timing_sigma_s,
                self.mag_norm_tolerance,
                self.mag_dip_tolerance_rad,
                self.near_vertical_rad,
                self.near_vertical_hysteresis_rad,
            ],
            &[
                "attitude.gyro_noise_rad_s_rthz",
                "attitude.gyro_scale_sigma",
                "attitude.gyro_bias_walk_rad_s_rts",
                "attitude.gyro_bias_sigma_rad_s",
                "attitude.velocity_sigma_m_s",
                "attitude.accel_sigma_m_s2",
                "attitude.mag_sigma_rad",
                "attitude.mag_timing_sigma_s",
                "attitude.mag_norm_tolerance",
                "attitude.mag_dip_tolerance_rad",
                "attitude.near_vertical_rad",
                "attitude.near_vertical_hysteresis_rad",
            ],
        )?;
        if self.gyro_bias_walk_rad_s_rts > 1.0 {
            return Err(ConfigError { field: "attitude.gyro_bias_walk_rad_s_rts", must_be: "at most 1" });
        }
        Ok(())
    }
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
            mag_dip_tolerance_rad: 0.1,
            near_vertical_rad: 5.0_f32.to_radians(),
            near_vertical_hysteresis_rad: 0.5_f32.to_radians(),
        }
    }
}
