//! Settings of the attitude filter.

use super::{ConfigError, all_positive};

/// Settings of the attitude filter. Standard deviations are those of errors left after compensation and
/// calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct AttitudeConfig {
    /// Angle random walk of the gyro, rad/s per root hertz. Default 1.75e-4 (0.01 deg/s/rtHz, a common MEMS
    /// data-sheet value: MPU-9250 PS section 3.1).
    pub gyro_noise_rad_s_rthz: f32,
    /// Scale factor and coupling error of the compensated gyro, dimensionless. A larger value gives the vectors more
    /// weight while the probe turns. Default 0.015: sensitivity within 3 % and cross-axis within 2 % (MPU-9250 PS
    /// section 3.1), each uniform, are 0.014 rms over the nine elements. When an accepted P replaces one that was
    /// wrong, P's deviations replace this value where they are smaller. Half of the variance is a
    /// constant that the filter estimates, with `Motion::DrillString` until the first P is accepted.
    pub gyro_scale_sigma: f32,
    /// Bias random walk, rad/s per root second. Default 2e-5: the bias then wanders by 0.02 deg/s in 5
    /// minutes, like one of 0.02 deg/s/K that warms by a kelvin (LSM6DSO: 0.010, ICM-42688-P: 0.005 typical).
    pub gyro_bias_walk_rad_s_rts: f32,
    /// Deviation of the residual gyro bias at the start, and largest deviation after a change of P, rad/s. Default 0.02
    /// (1.2 deg/s): the zero-rate output of data sheets, 1 deg/s typical for an LSM6DSO, with its change over
    /// temperature.
    pub gyro_bias_sigma_rad_s: f32,
    /// Deviation of the probe's horizontal speed, m/s: the only assumption about its accelerations, whose integral it
    /// bounds. With a smaller value the filter finds gravity faster, but long accelerations tilt the attitude more.
    /// Default 0.5: a hand that swings by a quarter of a metre to both sides every two seconds has 0.55 rms, and pipe
    /// is tripped at some 0.5.
    pub velocity_sigma_m_s: f32,
    /// Constant error of the calibrated accelerometer, m/s^2. It cannot be observed and adds to the reported
    /// sigmas. Default 0.03 (3 mg).
    pub accel_sigma_m_s2: f32,
    /// Direction error of the calibrated field, radians, correlated over some seconds of motion. Default
    /// 0.03: a heading within 2.5 deg where the horizontal field is 30 microtesla (BMM150 data sheet, table
    /// 1), of a total of some 45.
    pub mag_sigma_rad: f32,
    /// Deviation of the magnetometer's delay against the gyro while it is unknown, seconds. Default 0.015
    /// (conversion and hold of a 100 Hz magnetometer). A configured or found delay is known to a millisecond.
    /// The hold of single readings, up to a hundredth of a second, is separate.
    pub mag_timing_sigma_s: f32,
    /// Relative difference of the total field from the reference above which the field is disturbed and not
    /// used. Default 0.1 (VQF's: Laidig and Seel, Information Fusion 91, 2023).
    pub mag_norm_tolerance: f32,
    /// Difference of the dip from the reference above which the field is disturbed and not used, radians. Default 0.1:
    /// allows the same change across the field as `mag_norm_tolerance` along it. A field that stays through 20 s of
    /// turning becomes the reference, even in place of a configured one; surveys compare the dip with the configured
    /// one.
    pub mag_dip_tolerance_rad: f32,
    /// Inclination below which azimuth and gravity toolface are singular and the magnetic toolface is
    /// reported, radians. Default 5 deg.
    pub near_vertical_rad: f32,
    /// Hysteresis of `near_vertical_rad`, radians. Default 0.5 deg.
    pub near_vertical_hysteresis_rad: f32,
}

impl AttitudeConfig {
    /// All-zero settings of a static filter before it is configured.
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
