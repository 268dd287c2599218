//! Configuration as one flat struct: every field of the library's [`Config`], under its path with underscores.

use crate::{
    choices::{motion, motion_number, search, search_number, truth},
    config_fault::ConfigFault,
    pointer::{check, get, put},
    status::MwdStatus,
    text,
};
use core::ffi::c_char;
use meerkat_mwd::{
    Config,
    compensation::{GyroModel, VectorModel},
    config::{
        AttitudeConfig, DynamicsConfig, Earth, FullScale, IdentificationConfig, Latency, SurveyConfig, SurveyErrors,
        SurveyLimits, VectorErrors,
    },
};

/// Version of `MwdConfig`. A field that is added, removed or reordered makes another one.
pub const MWD_CONFIG_VERSION: u32 = 2;
/// Configuration of the whole pipeline. `mwd_config_default` fills it; a program then changes what it knows better.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdConfig {
    /// `MWD_CONFIG_VERSION` of the header that the program was compiled with; every call reads it before the rest.
    pub version: u32,
    /// Nominal sample period, microseconds. Default 5,000 (200 Hz).
    pub sample_period_us: u32,
    /// Seed of the population search.
    pub seed: u64,
    /// Switches effects beyond the gyro's twelve parameters on: the library of effects, steps of the bias,
    /// and magnets that come and go. 0 or 1, the default.
    pub effects: u32,
    /// Full scale of the gyro, rad/s. NaN if it is not known.
    pub full_scale_gyro_rad_s: f32,
    /// Full scale of the accelerometer, m/s^2. NaN if it is not known.
    pub full_scale_accel_m_s2: f32,
    /// Full scale of the magnetometer, microtesla. NaN if it is not known.
    pub full_scale_mag_ut: f32,
    /// Factory's matrix P, row by row: `w = P (w_raw - b)`. Default the identity.
    pub gyro_p: [f32; 9],
    /// Factory's bias b, rad/s, subtracted before P.
    pub gyro_b_rad_s: [f32; 3],
    /// Matrix M of the accelerometer, row by row: `v = M (v_raw - offset)`. Default the identity.
    pub accel_matrix: [f32; 9],
    /// Offset of the accelerometer, m/s^2, subtracted before M.
    pub accel_offset_m_s2: [f32; 3],
    /// Matrix M of the magnetometer, row by row: `v = M (v_raw - offset)`. Default the identity.
    pub mag_matrix: [f32; 9],
    /// Offset of the magnetometer, microtesla, subtracted before M.
    pub mag_offset_ut: [f32; 3],
    /// Delay of the gyro, seconds. NaN if it is not known.
    pub latency_gyro_s: f32,
    /// Delay of the accelerometer, seconds. NaN if it is not known.
    pub latency_accel_s: f32,
    /// Delay of the magnetometer, seconds, including the mean wait for its sample; known to a millisecond. NaN if it is
    /// not known.
    pub latency_mag_s: f32,
    /// Local gravity, m/s^2. Default 9.80665 (standard gravity, ISO 80000-3).
    pub earth_gravity_m_s2: f32,
    /// Total magnetic field, microtesla. NaN if it is not known.
    pub earth_magnetic_field_ut: f32,
    /// Magnetic dip below the horizontal, radians. NaN if it is not known.
    pub earth_dip_rad: f32,
    /// Magnetic declination, radians east of true north. NaN if it is not known.
    pub earth_declination_rad: f32,
    /// Geodetic latitude, radians north. NaN if it is not known.
    pub earth_latitude_rad: f32,
    /// Angle random walk of the gyro, rad/s per root hertz. Default 1.75e-4 (0.01 deg/s/rtHz, a common MEMS
    /// data-sheet value).
    pub attitude_gyro_noise_rad_s_rthz: f32,
    /// Scale factor and coupling error of the compensated gyro, dimensionless. Default 0.015.
    pub attitude_gyro_scale_sigma: f32,
    /// Bias random walk, rad/s per root second. Default 2e-5.
    pub attitude_gyro_bias_walk_rad_s_rts: f32,
    /// Deviation of the residual gyro bias at the start, rad/s, and its largest after a change of P. Default
    /// 0.02 (1.2 deg/s).
    pub attitude_gyro_bias_sigma_rad_s: f32,
    /// Deviation of the probe's horizontal speed, m/s: the only assumption about its accelerations, whose
    /// integral it bounds. Default 0.5.
    pub attitude_velocity_sigma_m_s: f32,
    /// Constant error of the calibrated accelerometer, m/s^2. Default 0.03 (3 mg).
    pub attitude_accel_sigma_m_s2: f32,
    /// Direction error of the calibrated field, radians, correlated over some seconds of motion. Default
    /// 0.03.
    pub attitude_mag_sigma_rad: f32,
    /// Deviation of the magnetometer's delay against the gyro while it is unknown, seconds. Default 0.015
    /// (conversion and hold of a 100 Hz magnetometer).
    pub attitude_mag_timing_sigma_s: f32,
    /// Relative difference of the total field from the reference above which the field is disturbed and not
    /// used. Default 0.1, VQF's.
    pub attitude_mag_norm_tolerance: f32,
    /// Difference of the dip from the reference above which the field is disturbed and not used, radians.
    /// Default 0.1.
    pub attitude_mag_dip_tolerance_rad: f32,
    /// Inclination below which azimuth and gravity toolface are singular and the magnetic toolface is
    /// reported, radians. Default 5 deg.
    pub attitude_near_vertical_rad: f32,
    /// Hysteresis of that limit, radians. Default 0.5 deg.
    pub attitude_near_vertical_hysteresis_rad: f32,
    /// Kind of motion. Default `drill_string`. `MWD_MOTION_HAND` or `MWD_MOTION_DRILL_STRING`.
    pub identification_motion: u32,
    /// Elements of the magnetometer's matrix, except its scale. Default 0.03.
    pub identification_vector_errors_mag_matrix: f32,
    /// Hard iron, relative to the earth field's norm. Default 0.1.
    pub identification_vector_errors_hard_iron: f32,
    /// Delay of the magnetometer behind the gyro, seconds. Default 0.015.
    pub identification_vector_errors_mag_lag_s: f32,
    /// Elements of the accelerometer's matrix. Default 0.005.
    pub identification_vector_errors_accel_matrix: f32,
    /// Bias of the accelerometer, m/s^2. Default 0.2.
    pub identification_vector_errors_accel_bias_m_s2: f32,
    /// Delay of the accelerometer behind the gyro, seconds. Default 0.005.
    pub identification_vector_errors_accel_lag_s: f32,
    /// Interval between updates of the flown model, seconds. Default 5.
    pub identification_update_s: f32,
    /// Length of a window, which is reported and searched, seconds. Default 50.
    pub identification_window_s: f32,
    /// Interval between the ends of windows, seconds; a window ends with the first update at which it is due.
    /// Default 25.
    pub identification_step_s: f32,
    /// Time from the request of an update, or of a window, to its effect, seconds. Default 1.
    pub identification_latency_s: f32,
    /// Prior standard deviation of P's diagonal about the factory's. Default 0.06.
    pub identification_prior_sigma_diagonal: f32,
    /// Prior standard deviation of P's off-diagonal. Default 0.03.
    pub identification_prior_sigma_off_diagonal: f32,
    /// Prior standard deviation of the bias, rad/s. Default 0.021 (1.2 deg/s).
    pub identification_prior_sigma_bias_rad_s: f32,
    /// Time in which the watch for magnets forgets what it has learnt of the gyro, seconds: each error's
    /// variance grows by its prior's in this time. Default 3,600.
    pub identification_forgetting_s: f32,
    /// Largest gyro deviation on any axis in a second of rest, rad/s. Default 0.5 deg/s.
    pub identification_rest_gyro_deviation_rad_s: f32,
    /// Largest mean rate of an axis that can be a bias, rad/s; a larger one is rotation, however steady, unless
    /// gravity and field both show that nothing turns. Default 0.17 (10 deg/s).
    pub identification_max_bias_rad_s: f32,
    /// Search method: `MWD_SEARCH_IMOA` (default), `MWD_SEARCH_LM` or `MWD_SEARCH_LS`.
    pub identification_optimizer: u32,
    /// Largest number of cost evaluations of a search. Default 75, half as many again as IMOA needs from the
    /// least-squares point of a window.
    pub identification_max_evaluations: u32,
    /// True if gravity and field come from a reference attitude and not from sensors (bench mode). Default
    /// false. 0 or 1.
    pub identification_vectors_from_reference: u32,
    /// Time at rest before averaging begins, seconds, in which the drill string untwists. Default 5.
    pub survey_settle_s: f32,
    /// Length of the average, seconds. Default 10.
    pub survey_average_s: f32,
    /// Turn of gravity or field since the average began that restarts a survey, radians. Default 0.5 deg.
    pub survey_max_turn_rad: f32,
    /// Axial rate at which the tool counts as rotating, rad/s; it stops counting below half of it. Default 5
    /// rpm.
    pub survey_rotating_rad_s: f32,
    /// Whole turns in one rotating survey. Default 10.
    pub survey_rotating_turns: u16,
    /// Inclination below which the magnetic toolface applies, radians. Default 5 deg.
    pub survey_near_vertical_rad: f32,
    /// Hysteresis of that limit: the gravity toolface applies again above their sum, radians. Default 0.5
    /// deg.
    pub survey_near_vertical_hysteresis_rad: f32,
    /// Angle from the probe's highside (x axis) to the motor's scribe line, by which one steers, radians
    /// clockwise looking down-hole. Default 0.
    pub survey_toolface_offset_rad: f32,
    /// Grid convergence, radians, grid north east of true north: grid azimuth is true azimuth less this.
    /// Default `None`. NaN if it is not known.
    pub survey_grid_convergence_rad: f32,
    /// Bias of each accelerometer axis, m/s^2. Default 0.004 (ABXY, ABZ).
    pub survey_errors_accel_bias_m_s2: f32,
    /// Scale factor of each accelerometer axis, dimensionless. Default 0.0005 (ASXY, ASZ).
    pub survey_errors_accel_scale: f32,
    /// Bias of each magnetometer axis, microtesla. Default 0.07 (MBXY, MBZ: 70 nT).
    pub survey_errors_mag_bias_ut: f32,
    /// Scale factor of each magnetometer axis, dimensionless. Default 0.0016 (MSXY, MSZ).
    pub survey_errors_mag_scale: f32,
    /// Field of the drill string along the tool axis, microtesla; 0: none. Default 0.22 (AMIL of
    /// revision 4).
    pub survey_errors_axial_interference_ut: f32,
    /// Declination of the reference, radians: the part that is the same everywhere. Default 0.36 deg (DEC).
    pub survey_errors_declination_rad: f32,
    /// Declination of the reference, radian microtesla, to be divided by the horizontal field. Default 5,000
    /// deg nT (DBH).
    pub survey_errors_declination_rad_ut: f32,
    /// Total field of the reference, microtesla. Default 0.13 (MFI: 130 nT).
    pub survey_errors_total_field_ut: f32,
    /// Dip of the reference, radians. Default 0.20 deg (MDI).
    pub survey_errors_dip_rad: f32,
    /// Time left between the accelerometer's and the magnetometer's reading, seconds; it turns the azimuth
    /// measured while rotating. Default 0.001.
    pub survey_errors_mag_timing_s: f32,
    /// True if the limits follow from the error model: `deviations` standard deviations of measured less
    /// reference at that attitude. 0 or 1.
    pub survey_limits_propagated: u32,
    /// Total field, microtesla. Default 0.3 (300 nT: the ISCWSA's Introduction to wellbore
    /// positioning, 22.1 Checking raw data).
    pub survey_limits_field_ut: f32,
    /// Dip, radians. Default 0.25 deg (same source).
    pub survey_limits_dip_rad: f32,
    /// Total gravity, m/s^2. Default 2.5 mg, a common rule without a source here.
    pub survey_limits_gravity_m_s2: f32,
    /// Standard deviations within which a survey is good if limits are propagated. Default 2 (95 %).
    pub survey_limits_deviations: f32,
    /// Ratio to a limit beyond which a survey is bad; between one and this it is doubtful. Default 1.5.
    pub survey_limits_bad_over_limit: f32,
    /// Length of a window, seconds. Default 30.
    pub survey_dynamics_window_s: f32,
    /// Averaging time of the rate before its least and largest are taken, seconds. Default 0.1.
    pub survey_dynamics_rate_averaging_s: f32,
    /// Vibration that counts as a shock, m/s^2. Default 10 g.
    pub survey_dynamics_shock_m_s2: f32,
    /// Time for which vibration must stay below half of `shock_m_s2` to end a shock, seconds. Default 0.02.
    pub survey_dynamics_shock_pause_s: f32,
}

impl From<&Config> for MwdConfig {
    fn from(config: &Config) -> Self {
        Self {
            version: MWD_CONFIG_VERSION,
            sample_period_us: config.sample_period_us,
            seed: config.seed,
            effects: config.effects.into(),
            full_scale_gyro_rad_s: or_nan(config.full_scale.gyro_rad_s),
            full_scale_accel_m_s2: or_nan(config.full_scale.accel_m_s2),
            full_scale_mag_ut: or_nan(config.full_scale.mag_ut),
            gyro_p: flat(&config.gyro.p),
            gyro_b_rad_s: config.gyro.b_rad_s,
            accel_matrix: flat(&config.accel.matrix),
            accel_offset_m_s2: config.accel.offset,
            mag_matrix: flat(&config.mag.matrix),
            mag_offset_ut: config.mag.offset,
            latency_gyro_s: or_nan(config.latency.gyro_s),
            latency_accel_s: or_nan(config.latency.accel_s),
            latency_mag_s: or_nan(config.latency.mag_s),
            earth_gravity_m_s2: config.earth.gravity_m_s2,
            earth_magnetic_field_ut: or_nan(config.earth.magnetic_field_ut),
            earth_dip_rad: or_nan(config.earth.dip_rad),
            earth_declination_rad: or_nan(config.earth.declination_rad),
            earth_latitude_rad: or_nan(config.earth.latitude_rad),
            attitude_gyro_noise_rad_s_rthz: config.attitude.gyro_noise_rad_s_rthz,
            attitude_gyro_scale_sigma: config.attitude.gyro_scale_sigma,
            attitude_gyro_bias_walk_rad_s_rts: config.attitude.gyro_bias_walk_rad_s_rts,
            attitude_gyro_bias_sigma_rad_s: config.attitude.gyro_bias_sigma_rad_s,
            attitude_velocity_sigma_m_s: config.attitude.velocity_sigma_m_s,
            attitude_accel_sigma_m_s2: config.attitude.accel_sigma_m_s2,
            attitude_mag_sigma_rad: config.attitude.mag_sigma_rad,
            attitude_mag_timing_sigma_s: config.attitude.mag_timing_sigma_s,
            attitude_mag_norm_tolerance: config.attitude.mag_norm_tolerance,
            attitude_mag_dip_tolerance_rad: config.attitude.mag_dip_tolerance_rad,
            attitude_near_vertical_rad: config.attitude.near_vertical_rad,
            attitude_near_vertical_hysteresis_rad: config.attitude.near_vertical_hysteresis_rad,
            identification_motion: motion_number(config.identification.motion),
            identification_vector_errors_mag_matrix: config.identification.vector_errors.mag_matrix,
            identification_vector_errors_hard_iron: config.identification.vector_errors.hard_iron,
            identification_vector_errors_mag_lag_s: config.identification.vector_errors.mag_lag_s,
            identification_vector_errors_accel_matrix: config.identification.vector_errors.accel_matrix,
            identification_vector_errors_accel_bias_m_s2: config.identification.vector_errors.accel_bias_m_s2,
            identification_vector_errors_accel_lag_s: config.identification.vector_errors.accel_lag_s,
            identification_update_s: config.identification.update_s,
            identification_window_s: config.identification.window_s,
            identification_step_s: config.identification.step_s,
            identification_latency_s: config.identification.latency_s,
            identification_prior_sigma_diagonal: config.identification.prior_sigma_diagonal,
            identification_prior_sigma_off_diagonal: config.identification.prior_sigma_off_diagonal,
            identification_prior_sigma_bias_rad_s: config.identification.prior_sigma_bias_rad_s,
            identification_forgetting_s: config.identification.forgetting_s,
            identification_rest_gyro_deviation_rad_s: config.identification.rest_gyro_deviation_rad_s,
            identification_max_bias_rad_s: config.identification.max_bias_rad_s,
            identification_optimizer: search_number(config.identification.optimizer),
            identification_max_evaluations: config.identification.max_evaluations,
            identification_vectors_from_reference: config.identification.vectors_from_reference.into(),
            survey_settle_s: config.survey.settle_s,
            survey_average_s: config.survey.average_s,
            survey_max_turn_rad: config.survey.max_turn_rad,
            survey_rotating_rad_s: config.survey.rotating_rad_s,
            survey_rotating_turns: config.survey.rotating_turns,
            survey_near_vertical_rad: config.survey.near_vertical_rad,
            survey_near_vertical_hysteresis_rad: config.survey.near_vertical_hysteresis_rad,
            survey_toolface_offset_rad: config.survey.toolface_offset_rad,
            survey_grid_convergence_rad: or_nan(config.survey.grid_convergence_rad),
            survey_errors_accel_bias_m_s2: config.survey.errors.accel_bias_m_s2,
            survey_errors_accel_scale: config.survey.errors.accel_scale,
            survey_errors_mag_bias_ut: config.survey.errors.mag_bias_ut,
            survey_errors_mag_scale: config.survey.errors.mag_scale,
            survey_errors_axial_interference_ut: config.survey.errors.axial_interference_ut,
            survey_errors_declination_rad: config.survey.errors.declination_rad,
            survey_errors_declination_rad_ut: config.survey.errors.declination_rad_ut,
            survey_errors_total_field_ut: config.survey.errors.total_field_ut,
            survey_errors_dip_rad: config.survey.errors.dip_rad,
            survey_errors_mag_timing_s: config.survey.errors.mag_timing_s,
            survey_limits_propagated: config.survey.limits.propagated.into(),
            survey_limits_field_ut: config.survey.limits.field_ut,
            survey_limits_dip_rad: config.survey.limits.dip_rad,
            survey_limits_gravity_m_s2: config.survey.limits.gravity_m_s2,
            survey_limits_deviations: config.survey.limits.deviations,
            survey_limits_bad_over_limit: config.survey.limits.bad_over_limit,
            survey_dynamics_window_s: config.survey.dynamics.window_s,
            survey_dynamics_rate_averaging_s: config.survey.dynamics.rate_averaging_s,
            survey_dynamics_shock_m_s2: config.survey.dynamics.shock_m_s2,
            survey_dynamics_shock_pause_s: config.survey.dynamics.shock_pause_s,
        }
    }
}

impl MwdConfig {
    /// Makes the library's configuration, which is not checked yet.
    pub(crate) fn to_config(self) -> Result<Config, ConfigFault> {
        if self.version != MWD_CONFIG_VERSION {
            return Err(ConfigFault::Version);
        }
        Ok(Config {
            sample_period_us: self.sample_period_us,
            seed: self.seed,
            effects: truth(self.effects, "effects")?,
            full_scale: FullScale {
                gyro_rad_s: known(self.full_scale_gyro_rad_s),
                accel_m_s2: known(self.full_scale_accel_m_s2),
                mag_ut: known(self.full_scale_mag_ut),
            },
            gyro: GyroModel { p: rows(&self.gyro_p), b_rad_s: self.gyro_b_rad_s },
            accel: VectorModel { matrix: rows(&self.accel_matrix), offset: self.accel_offset_m_s2 },
            mag: VectorModel { matrix: rows(&self.mag_matrix), offset: self.mag_offset_ut },
            latency: Latency {
                gyro_s: known(self.latency_gyro_s),
                accel_s: known(self.latency_accel_s),
                mag_s: known(self.latency_mag_s),
            },
            earth: Earth {
                gravity_m_s2: self.earth_gravity_m_s2,
                magnetic_field_ut: known(self.earth_magnetic_field_ut),
                dip_rad: known(self.earth_dip_rad),
                declination_rad: known(self.earth_declination_rad),
                latitude_rad: known(self.earth_latitude_rad),
            },
            attitude: AttitudeConfig {
                gyro_noise_rad_s_rthz: self.attitude_gyro_noise_rad_s_rthz,
                gyro_scale_sigma: self.attitude_gyro_scale_sigma,
                gyro_bias_walk_rad_s_rts: self.attitude_gyro_bias_walk_rad_s_rts,
                gyro_bias_sigma_rad_s: self.attitude_gyro_bias_sigma_rad_s,
                velocity_sigma_m_s: self.attitude_velocity_sigma_m_s,
                accel_sigma_m_s2: self.attitude_accel_sigma_m_s2,
                mag_sigma_rad: self.attitude_mag_sigma_rad,
                mag_timing_sigma_s: self.attitude_mag_timing_sigma_s,
                mag_norm_tolerance: self.attitude_mag_norm_tolerance,
                mag_dip_tolerance_rad: self.attitude_mag_dip_tolerance_rad,
                near_vertical_rad: self.attitude_near_vertical_rad,
                near_vertical_hysteresis_rad: self.attitude_near_vertical_hysteresis_rad,
            },
            identification: IdentificationConfig {
                motion: motion(self.identification_motion, "identification_motion")?,
                vector_errors: VectorErrors {
                    mag_matrix: self.identification_vector_errors_mag_matrix,
                    hard_iron: self.identification_vector_errors_hard_iron,
                    mag_lag_s: self.identification_vector_errors_mag_lag_s,
                    accel_matrix: self.identification_vector_errors_accel_matrix,
                    accel_bias_m_s2: self.identification_vector_errors_accel_bias_m_s2,
                    accel_lag_s: self.identification_vector_errors_accel_lag_s,
                },
                update_s: self.identification_update_s,
                window_s: self.identification_window_s,
                step_s: self.identification_step_s,
                latency_s: self.identification_latency_s,
                prior_sigma_diagonal: self.identification_prior_sigma_diagonal,
                prior_sigma_off_diagonal: self.identification_prior_sigma_off_diagonal,
                prior_sigma_bias_rad_s: self.identification_prior_sigma_bias_rad_s,
                forgetting_s: self.identification_forgetting_s,
                rest_gyro_deviation_rad_s: self.identification_rest_gyro_deviation_rad_s,
                max_bias_rad_s: self.identification_max_bias_rad_s,
                optimizer: search(self.identification_optimizer, "identification_optimizer")?,
                max_evaluations: self.identification_max_evaluations,
                vectors_from_reference: truth(
                    self.identification_vectors_from_reference,
                    "identification_vectors_from_reference",
                )?,
            },
            survey: SurveyConfig {
                settle_s: self.survey_settle_s,
                average_s: self.survey_average_s,
                max_turn_rad: self.survey_max_turn_rad,
                rotating_rad_s: self.survey_rotating_rad_s,
                rotating_turns: self.survey_rotating_turns,
                near_vertical_rad: self.survey_near_vertical_rad,
                near_vertical_hysteresis_rad: self.survey_near_vertical_hysteresis_rad,
                toolface_offset_rad: self.survey_toolface_offset_rad,
                grid_convergence_rad: known(self.survey_grid_convergence_rad),
                errors: SurveyErrors {
                    accel_bias_m_s2: self.survey_errors_accel_bias_m_s2,
                    accel_scale: self.survey_errors_accel_scale,
                    mag_bias_ut: self.survey_errors_mag_bias_ut,
                    mag_scale: self.survey_errors_mag_scale,
                    axial_interference_ut: self.survey_errors_axial_interference_ut,
                    declination_rad: self.survey_errors_declination_rad,
                    declination_rad_ut: self.survey_errors_declination_rad_ut,
                    total_field_ut: self.survey_errors_total_field_ut,
                    dip_rad: self.survey_errors_dip_rad,
                    mag_timing_s: self.survey_errors_mag_timing_s,
                },
                limits: SurveyLimits {
                    propagated: truth(self.survey_limits_propagated, "survey_limits_propagated")?,
                    field_ut: self.survey_limits_field_ut,
                    dip_rad: self.survey_limits_dip_rad,
                    gravity_m_s2: self.survey_limits_gravity_m_s2,
                    deviations: self.survey_limits_deviations,
                    bad_over_limit: self.survey_limits_bad_over_limit,
                },
                dynamics: DynamicsConfig {
                    window_s: self.survey_dynamics_window_s,
                    rate_averaging_s: self.survey_dynamics_rate_averaging_s,
                    shock_m_s2: self.survey_dynamics_shock_m_s2,
                    shock_pause_s: self.survey_dynamics_shock_pause_s,
                },
            },
        })
    }

    /// Checks every field.
    fn check(self) -> Result<Config, ConfigFault> {
        let config = self.to_config()?;
        config.validate().map_err(ConfigFault::Field)?;
        Ok(config)
    }

    /// Returns the library's configuration if every field can be used.
    #[must_use]
    pub fn checked_config(self) -> Option<Config> {
        self.checked().ok()
    }

    /// Returns the configuration if every field can be used, and the outcome of the call otherwise.
    pub(crate) fn checked(self) -> Result<Config, MwdStatus> {
        self.check().map_err(|fault| fault.status())
    }
}

fn or_nan(value: Option<f32>) -> f32 {
    value.unwrap_or(f32::NAN)
}

fn known(value: f32) -> Option<f32> {
    (!value.is_nan()).then_some(value)
}

fn flat(rows: &[[f32; 3]; 3]) -> [f32; 9] {
    let [[a, b, c], [d, e, f], [g, h, i]] = *rows;
    [a, b, c, d, e, f, g, h, i]
}

fn rows(flat: &[f32; 9]) -> [[f32; 3]; 3] {
    let [a, b, c, d, e, f, g, h, i] = *flat;
    [[a, b, c], [d, e, f], [g, h, i]]
}

/// Copies a configuration of this version.
///
/// # Safety
/// `config` is NULL or leads to an `MwdConfig` of any version; each begins with its version.
pub(crate) unsafe fn read(config: *const MwdConfig) -> Result<MwdConfig, MwdStatus> {
    check(config)?;
    // SAFETY: the caller's promise; a struct of another version may be shorter than this one.
    match unsafe { get(config.cast::<u32>()) }? {
        // SAFETY: the caller's promise.
        MWD_CONFIG_VERSION => unsafe { get(config) },
        _ => Err(MwdStatus::ErrorVersion),
    }
}

/// Fills a configuration with the defaults. Give it `MWD_CONFIG_VERSION` and `sizeof` the configuration: with those of
/// another header than the library's nothing is written, and it returns `MWD_STATUS_ERROR_VERSION`.
///
/// # Safety
/// `config` is NULL or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_config_default(config: *mut MwdConfig, version: u32, bytes: usize) -> MwdStatus {
    if config.is_null() {
        return MwdStatus::ErrorNull;
    }
    if (version, bytes) != (MWD_CONFIG_VERSION, size_of::<MwdConfig>()) {
        return MwdStatus::ErrorVersion;
    }
    // SAFETY: the caller's promise.
    unsafe { put(config, MwdConfig::from(&Config::default())) }
}

/// Checks every field of a configuration. `reason` takes a text such as `earth.dip_rad must be -pi/2 to pi/2`, cut
/// off after `reason_bytes - 1` bytes and ended by a zero; of a valid configuration it is empty. The dots are
/// underscores in `MwdConfig`.
///
/// # Safety
/// `config` is NULL or points to an `MwdConfig`; `reason` is NULL or points to `reason_bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_config_validate(
    config: *const MwdConfig,
    reason: *mut c_char,
    reason_bytes: usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let checked = match unsafe { read(config) } {
        Ok(config) => config.check().map(|_| ()),
        Err(MwdStatus::ErrorVersion) => Err(ConfigFault::Version),
        Err(status) => return status,
    };
    let (status, parts) = match checked {
        Ok(()) => (MwdStatus::Ok, ["", "", ""]),
        Err(fault) => {
            let [field, must_be] = fault.texts();
            (fault.status(), [field, " must be ", must_be])
        }
    };
    // SAFETY: the caller's promise.
    unsafe { text::put(parts, reason, reason_bytes) };
    status
}
