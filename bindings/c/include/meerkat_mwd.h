/* C interface of meerkat-mwd. Made by cbindgen from bindings/c/src; docs/c.md is the guide. C99 and C++17. */

#ifndef MEERKAT_MWD_H
#define MEERKAT_MWD_H

#include <stddef.h>
#include <stdint.h>

/**
 * Bytes of storage for an `MwdProbe`.
 */
#define MWD_PROBE_SIZE 96256

/**
 * Alignment of that storage, bytes: an array of `uint64_t` has it.
 */
#define MWD_PROBE_ALIGN 8

/**
 * Bytes of storage for an `MwdSurveyor`.
 */
#define MWD_SURVEYOR_SIZE 2048

/**
 * Alignment of that storage, bytes.
 */
#define MWD_SURVEYOR_ALIGN 8

/**
 * Bytes of storage for an `MwdAttitudeFilter`.
 */
#define MWD_ATTITUDE_FILTER_SIZE 2048

/**
 * Alignment of that storage, bytes.
 */
#define MWD_ATTITUDE_FILTER_ALIGN 8

/**
 * Bytes of storage for an `MwdMountingCheck`.
 */
#define MWD_MOUNTING_CHECK_SIZE 1024

/**
 * Alignment of that storage, bytes.
 */
#define MWD_MOUNTING_CHECK_ALIGN 8

/**
 * Version of `MwdConfig`. A field that is added, removed or reordered makes another one.
 */
#define MWD_CONFIG_VERSION 2

/**
 * Motion by a hand that turns and swings the probe.
 */
#define MWD_MOTION_HAND 0

/**
 * Motion in a drill string, or on a rig that turns the probe without carrying it about. The default.
 */
#define MWD_MOTION_DRILL_STRING 1

/**
 * Search by the improved meerkat optimisation algorithm. The default.
 */
#define MWD_SEARCH_IMOA 0

/**
 * Search by Levenberg-Marquardt.
 */
#define MWD_SEARCH_LM 1

/**
 * No search: the estimator's mean itself.
 */
#define MWD_SEARCH_LS 2

/**
 * The gyro gave no reading.
 */
#define MWD_SAMPLE_GYRO_MISSING 1

/**
 * The accelerometer gave no reading.
 */
#define MWD_SAMPLE_ACCEL_MISSING 2

/**
 * The magnetometer gave no reading.
 */
#define MWD_SAMPLE_MAG_MISSING 4

/**
 * There is no temperature.
 */
#define MWD_SAMPLE_TEMPERATURE_MISSING 8

/**
 * A gyro axis is at its full scale.
 */
#define MWD_SAMPLE_GYRO_CLIPPED 16

/**
 * An accelerometer axis is at its full scale.
 */
#define MWD_SAMPLE_ACCEL_CLIPPED 32

/**
 * A magnetometer axis is at its full scale.
 */
#define MWD_SAMPLE_MAG_CLIPPED 64

/**
 * The driver reported a fault: no reading of this sample is used.
 */
#define MWD_SAMPLE_FAULT 128

/**
 * The gyro gave no reading for this sample: the last rate was held.
 */
#define MWD_ATTITUDE_GYRO_HELD 1

/**
 * A gyro axis is at its full scale: the rotation is a lower bound.
 */
#define MWD_ATTITUDE_GYRO_CLIPPED 2

/**
 * The accelerometer was missing, clipped or rejected for this sample.
 */
#define MWD_ATTITUDE_ACCEL_UNUSED 4

/**
 * The magnetometer was missing, clipped, zero or rejected for this sample.
 */
#define MWD_ATTITUDE_MAG_UNUSED 8

/**
 * Heading has never been observed: azimuth counts from an arbitrary north.
 */
#define MWD_ATTITUDE_NO_HEADING 16

/**
 * The hole is near vertical: the magnetic toolface applies.
 */
#define MWD_ATTITUDE_NEAR_VERTICAL 32

/**
 * A gap in time came before this sample.
 */
#define MWD_ATTITUDE_AFTER_GAP 64

/**
 * The driver reported a fault with this sample.
 */
#define MWD_ATTITUDE_FAULT 128

/**
 * A sensor has not changed its reading for a second.
 */
#define MWD_ATTITUDE_FROZEN_SENSOR 256

/**
 * P and b fly.
 */
#define MWD_ACCEPTED 0

/**
 * Refused: too little motion. Numbers: motion, and motion needed, seconds.
 */
#define MWD_REFUSED_NOT_ENOUGH_MOTION 1

/**
 * Refused: the result was not ready at its instant.
 */
#define MWD_REFUSED_OVERRUN 2

/**
 * Refused: the accelerometer reads nothing usable.
 */
#define MWD_REFUSED_NO_ACCELEROMETER 3

/**
 * Refused: the gyro cannot be used. Number: share of the time.
 */
#define MWD_REFUSED_GYRO_UNUSABLE 4

/**
 * Refused: the innovations are larger than the estimator thinks. Number: mean squared innovation.
 */
#define MWD_REFUSED_DIVERGED 5

/**
 * Refused: too little of the motion has a field. Number: share of the motion without one.
 */
#define MWD_REFUSED_NO_MAGNETOMETER 6

/**
 * Refused: P is farther from the factory's than any data sheet allows. Number: deviations of the prior.
 */
#define MWD_REFUSED_IMPLAUSIBLE 7

/**
 * Refused: the magnetometer needs a calibration first. Number: hard iron, of the field's norm.
 */
#define MWD_REFUSED_MAGNETOMETER_UNCALIBRATED 8

/**
 * Refused for a reason that a newer library has.
 */
#define MWD_REFUSED_OTHERWISE 9

/**
 * Refused: the sensors do not agree on turns. Number: the turns, as bits: about x, y and z by gravity, then by the
 * field.
 */
#define MWD_REFUSED_WRONG_MOUNTING 10

/**
 * Bytes of a name, with the zero that ends it.
 */
#define MWD_NAME_SIZE 32

/**
 * Largest number of effects that are taken out at a time.
 */
#define MWD_MAX_EFFECTS 8

/**
 * The field is not used while the magnet is there: it came after the probe was frozen and matches none known before.
 */
#define MWD_FIELD_WITHHELD 0

/**
 * The magnet's offset is taken out of the field.
 */
#define MWD_FIELD_CORRECTED 1

/**
 * The magnet came before the probe had turned. The field was used as it came; the magnet was told when it left.
 */
#define MWD_FIELD_TOLD_AFTERWARDS 2

/**
 * A newer library does something else about it.
 */
#define MWD_FIELD_OTHERWISE 3

/**
 * Survey of the attitude filter at one sample.
 */
#define MWD_SURVEY_CONTINUOUS 0

/**
 * Survey of mean vectors at rest; also a bit of the news of `mwd_surveyor_push`.
 */
#define MWD_SURVEY_STATIONARY 1

/**
 * Survey of mean vectors over whole turns; also a bit of the news of `mwd_surveyor_push`.
 */
#define MWD_SURVEY_ROTATING 2

/**
 * Every possible check is within its limit.
 */
#define MWD_GRADE_GOOD 0

/**
 * A check is beyond its limit.
 */
#define MWD_GRADE_DOUBTFUL 1

/**
 * A check is far beyond its limit, or a measurement that it needs is missing.
 */
#define MWD_GRADE_BAD 2

/**
 * Not graded: a survey of the attitude filter.
 */
#define MWD_GRADE_NONE 3

/**
 * A turn about x, by gyro and gravity. The bits of `MwdMounting`.
 */
#define MWD_TURN_X_BY_ACCEL 1

/**
 * A turn about y, by gyro and gravity.
 */
#define MWD_TURN_Y_BY_ACCEL 2

/**
 * A turn about z, by gyro and gravity.
 */
#define MWD_TURN_Z_BY_ACCEL 4

/**
 * A turn about x, by gyro and field.
 */
#define MWD_TURN_X_BY_MAG 8

/**
 * A turn about y, by gyro and field.
 */
#define MWD_TURN_Y_BY_MAG 16

/**
 * A turn about z, by gyro and field.
 */
#define MWD_TURN_Z_BY_MAG 32

/**
 * Bytes that hold every frame of this interface.
 */
#define MWD_FRAME_SIZE 1300

/**
 * Bytes of a probe's unique number.
 */
#define MWD_PROBE_ID_SIZE 12

/**
 * Outcome of a call. Errors are below zero: the probe is then as it was, and what a call writes means nothing.
 */
enum MwdStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    MWD_STATUS_OK = 0,
    /**
     * Nothing to give: no report is ready, no survey was taken, or the sample was not taken because of its time.
     */
    MWD_STATUS_NOTHING = 1,
    /**
     * A pointer is NULL.
     */
    MWD_STATUS_ERROR_NULL = -1,
    /**
     * A pointer is not aligned for what it leads to.
     */
    MWD_STATUS_ERROR_MISALIGNED = -2,
    /**
     * The memory that was given is too small.
     */
    MWD_STATUS_ERROR_TOO_SMALL = -3,
    /**
     * The configuration is of another version of the header.
     */
    MWD_STATUS_ERROR_VERSION = -4,
    /**
     * A field of the configuration cannot be used; `mwd_config_validate` says which and why.
     */
    MWD_STATUS_ERROR_CONFIG = -5,
    /**
     * It is not configured yet.
     */
    MWD_STATUS_ERROR_NOT_CONFIGURED = -6,
    /**
     * A number of an argument stands for nothing.
     */
    MWD_STATUS_ERROR_ARGUMENT = -7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum MwdStatus MwdStatus;
#else
typedef int32_t MwdStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * The attitude filter, in storage of the caller.
 */
typedef struct MwdAttitudeFilter MwdAttitudeFilter;

/**
 * Check of signs, units and axes of the sensors by turns of the probe, in storage of the caller.
 */
typedef struct MwdMountingCheck MwdMountingCheck;

/**
 * The whole pipeline with all its buffers, in storage of the caller.
 */
typedef struct MwdProbe MwdProbe;

/**
 * Taker of surveys, in storage of the caller.
 */
typedef struct MwdSurveyor MwdSurveyor;

/**
 * Configuration of the whole pipeline. `mwd_config_default` fills it; a program then changes what it knows better.
 */
typedef struct {
    /**
     * `MWD_CONFIG_VERSION` of the header that the program was compiled with; every call reads it before the rest.
     */
    uint32_t version;
    /**
     * Nominal sample period, microseconds. Default 5,000 (200 Hz).
     */
    uint32_t sample_period_us;
    /**
     * Seed of the population search.
     */
    uint64_t seed;
    /**
     * Switches effects beyond the gyro's twelve parameters on: the library of effects, steps of the bias,
     * and magnets that come and go. 0 or 1, the default.
     */
    uint32_t effects;
    /**
     * Full scale of the gyro, rad/s. NaN if it is not known.
     */
    float full_scale_gyro_rad_s;
    /**
     * Full scale of the accelerometer, m/s^2. NaN if it is not known.
     */
    float full_scale_accel_m_s2;
    /**
     * Full scale of the magnetometer, microtesla. NaN if it is not known.
     */
    float full_scale_mag_ut;
    /**
     * Factory's matrix P, row by row: `w = P (w_raw - b)`. Default the identity.
     */
    float gyro_p[9];
    /**
     * Factory's bias b, rad/s, subtracted before P.
     */
    float gyro_b_rad_s[3];
    /**
     * Matrix M of the accelerometer, row by row: `v = M (v_raw - offset)`. Default the identity.
     */
    float accel_matrix[9];
    /**
     * Offset of the accelerometer, m/s^2, subtracted before M.
     */
    float accel_offset_m_s2[3];
    /**
     * Matrix M of the magnetometer, row by row: `v = M (v_raw - offset)`. Default the identity.
     */
    float mag_matrix[9];
    /**
     * Offset of the magnetometer, microtesla, subtracted before M.
     */
    float mag_offset_ut[3];
    /**
     * Delay of the gyro, seconds. NaN if it is not known.
     */
    float latency_gyro_s;
    /**
     * Delay of the accelerometer, seconds. NaN if it is not known.
     */
    float latency_accel_s;
    /**
     * Delay of the magnetometer, seconds, including the mean wait for its sample; known to a millisecond. NaN if it is
     * not known.
     */
    float latency_mag_s;
    /**
     * Local gravity, m/s^2. Default 9.80665 (standard gravity, ISO 80000-3).
     */
    float earth_gravity_m_s2;
    /**
     * Total magnetic field, microtesla. NaN if it is not known.
     */
    float earth_magnetic_field_ut;
    /**
     * Magnetic dip below the horizontal, radians. NaN if it is not known.
     */
    float earth_dip_rad;
    /**
     * Magnetic declination, radians east of true north. NaN if it is not known.
     */
    float earth_declination_rad;
    /**
     * Geodetic latitude, radians north. NaN if it is not known.
     */
    float earth_latitude_rad;
    /**
     * Angle random walk of the gyro, rad/s per root hertz. Default 1.75e-4 (0.01 deg/s/rtHz, a common MEMS
     * data-sheet value).
     */
    float attitude_gyro_noise_rad_s_rthz;
    /**
     * Scale factor and coupling error of the compensated gyro, dimensionless. Default 0.015.
     */
    float attitude_gyro_scale_sigma;
    /**
     * Bias random walk, rad/s per root second. Default 2e-5.
     */
    float attitude_gyro_bias_walk_rad_s_rts;
    /**
     * Deviation of the residual gyro bias at the start, rad/s, and its largest after a change of P. Default
     * 0.02 (1.2 deg/s).
     */
    float attitude_gyro_bias_sigma_rad_s;
    /**
     * Deviation of the probe's horizontal speed, m/s: the only assumption about its accelerations, whose
     * integral it bounds. Default 0.5.
     */
    float attitude_velocity_sigma_m_s;
    /**
     * Constant error of the calibrated accelerometer, m/s^2. Default 0.03 (3 mg).
     */
    float attitude_accel_sigma_m_s2;
    /**
     * Direction error of the calibrated field, radians, correlated over some seconds of motion. Default
     * 0.03.
     */
    float attitude_mag_sigma_rad;
    /**
     * Deviation of the magnetometer's delay against the gyro while it is unknown, seconds. Default 0.015
     * (conversion and hold of a 100 Hz magnetometer).
     */
    float attitude_mag_timing_sigma_s;
    /**
     * Relative difference of the total field from the reference above which the field is disturbed and not
     * used. Default 0.1, VQF's.
     */
    float attitude_mag_norm_tolerance;
    /**
     * Difference of the dip from the reference above which the field is disturbed and not used, radians.
     * Default 0.1.
     */
    float attitude_mag_dip_tolerance_rad;
    /**
     * Inclination below which azimuth and gravity toolface are singular and the magnetic toolface is
     * reported, radians. Default 5 deg.
     */
    float attitude_near_vertical_rad;
    /**
     * Hysteresis of that limit, radians. Default 0.5 deg.
     */
    float attitude_near_vertical_hysteresis_rad;
    /**
     * Kind of motion. Default `drill_string`. `MWD_MOTION_HAND` or `MWD_MOTION_DRILL_STRING`.
     */
    uint32_t identification_motion;
    /**
     * Elements of the magnetometer's matrix, except its scale. Default 0.03.
     */
    float identification_vector_errors_mag_matrix;
    /**
     * Hard iron, relative to the earth field's norm. Default 0.1.
     */
    float identification_vector_errors_hard_iron;
    /**
     * Delay of the magnetometer behind the gyro, seconds. Default 0.015.
     */
    float identification_vector_errors_mag_lag_s;
    /**
     * Elements of the accelerometer's matrix. Default 0.005.
     */
    float identification_vector_errors_accel_matrix;
    /**
     * Bias of the accelerometer, m/s^2. Default 0.2.
     */
    float identification_vector_errors_accel_bias_m_s2;
    /**
     * Delay of the accelerometer behind the gyro, seconds. Default 0.005.
     */
    float identification_vector_errors_accel_lag_s;
    /**
     * Interval between updates of the flown model, seconds. Default 5.
     */
    float identification_update_s;
    /**
     * Length of a window, which is reported and searched, seconds. Default 50.
     */
    float identification_window_s;
    /**
     * Interval between the ends of windows, seconds; a window ends with the first update at which it is due.
     * Default 25.
     */
    float identification_step_s;
    /**
     * Time from the request of an update, or of a window, to its effect, seconds. Default 1.
     */
    float identification_latency_s;
    /**
     * Prior standard deviation of P's diagonal about the factory's. Default 0.06.
     */
    float identification_prior_sigma_diagonal;
    /**
     * Prior standard deviation of P's off-diagonal. Default 0.03.
     */
    float identification_prior_sigma_off_diagonal;
    /**
     * Prior standard deviation of the bias, rad/s. Default 0.021 (1.2 deg/s).
     */
    float identification_prior_sigma_bias_rad_s;
    /**
     * Time in which the watch for magnets forgets what it has learnt of the gyro, seconds: each error's
     * variance grows by its prior's in this time. Default 3,600.
     */
    float identification_forgetting_s;
    /**
     * Largest gyro deviation on any axis in a second of rest, rad/s. Default 0.5 deg/s.
     */
    float identification_rest_gyro_deviation_rad_s;
    /**
     * Largest mean rate of an axis that can be a bias, rad/s; a larger one is rotation, however steady, unless
     * gravity and field both show that nothing turns. Default 0.17 (10 deg/s).
     */
    float identification_max_bias_rad_s;
    /**
     * Search method: `MWD_SEARCH_IMOA` (default), `MWD_SEARCH_LM` or `MWD_SEARCH_LS`.
     */
    uint32_t identification_optimizer;
    /**
     * Largest number of cost evaluations of a search. Default 75, half as many again as IMOA needs from the
     * least-squares point of a window.
     */
    uint32_t identification_max_evaluations;
    /**
     * True if gravity and field come from a reference attitude and not from sensors (bench mode). Default
     * false. 0 or 1.
     */
    uint32_t identification_vectors_from_reference;
    /**
     * Time at rest before averaging begins, seconds, in which the drill string untwists. Default 5.
     */
    float survey_settle_s;
    /**
     * Length of the average, seconds. Default 10.
     */
    float survey_average_s;
    /**
     * Turn of gravity or field since the average began that restarts a survey, radians. Default 0.5 deg.
     */
    float survey_max_turn_rad;
    /**
     * Axial rate at which the tool counts as rotating, rad/s; it stops counting below half of it. Default 5
     * rpm.
     */
    float survey_rotating_rad_s;
    /**
     * Whole turns in one rotating survey. Default 10.
     */
    uint16_t survey_rotating_turns;
    /**
     * Inclination below which the magnetic toolface applies, radians. Default 5 deg.
     */
    float survey_near_vertical_rad;
    /**
     * Hysteresis of that limit: the gravity toolface applies again above their sum, radians. Default 0.5
     * deg.
     */
    float survey_near_vertical_hysteresis_rad;
    /**
     * Angle from the probe's highside (x axis) to the motor's scribe line, by which one steers, radians
     * clockwise looking down-hole. Default 0.
     */
    float survey_toolface_offset_rad;
    /**
     * Grid convergence, radians, grid north east of true north: grid azimuth is true azimuth less this.
     * Default `None`. NaN if it is not known.
     */
    float survey_grid_convergence_rad;
    /**
     * Bias of each accelerometer axis, m/s^2. Default 0.004 (ABXY, ABZ).
     */
    float survey_errors_accel_bias_m_s2;
    /**
     * Scale factor of each accelerometer axis, dimensionless. Default 0.0005 (ASXY, ASZ).
     */
    float survey_errors_accel_scale;
    /**
     * Bias of each magnetometer axis, microtesla. Default 0.07 (MBXY, MBZ: 70 nT).
     */
    float survey_errors_mag_bias_ut;
    /**
     * Scale factor of each magnetometer axis, dimensionless. Default 0.0016 (MSXY, MSZ).
     */
    float survey_errors_mag_scale;
    /**
     * Field of the drill string along the tool axis, microtesla; 0: none. Default 0.22 (AMIL of
     * revision 4).
     */
    float survey_errors_axial_interference_ut;
    /**
     * Declination of the reference, radians: the part that is the same everywhere. Default 0.36 deg (DEC).
     */
    float survey_errors_declination_rad;
    /**
     * Declination of the reference, radian microtesla, to be divided by the horizontal field. Default 5,000
     * deg nT (DBH).
     */
    float survey_errors_declination_rad_ut;
    /**
     * Total field of the reference, microtesla. Default 0.13 (MFI: 130 nT).
     */
    float survey_errors_total_field_ut;
    /**
     * Dip of the reference, radians. Default 0.20 deg (MDI).
     */
    float survey_errors_dip_rad;
    /**
     * Time left between the accelerometer's and the magnetometer's reading, seconds; it turns the azimuth
     * measured while rotating. Default 0.001.
     */
    float survey_errors_mag_timing_s;
    /**
     * True if the limits follow from the error model: `deviations` standard deviations of measured less
     * reference at that attitude. 0 or 1.
     */
    uint32_t survey_limits_propagated;
    /**
     * Total field, microtesla. Default 0.3 (300 nT: the ISCWSA's Introduction to wellbore
     * positioning, 22.1 Checking raw data).
     */
    float survey_limits_field_ut;
    /**
     * Dip, radians. Default 0.25 deg (same source).
     */
    float survey_limits_dip_rad;
    /**
     * Total gravity, m/s^2. Default 2.5 mg, a common rule without a source here.
     */
    float survey_limits_gravity_m_s2;
    /**
     * Standard deviations within which a survey is good if limits are propagated. Default 2 (95 %).
     */
    float survey_limits_deviations;
    /**
     * Ratio to a limit beyond which a survey is bad; between one and this it is doubtful. Default 1.5.
     */
    float survey_limits_bad_over_limit;
    /**
     * Length of a window, seconds. Default 30.
     */
    float survey_dynamics_window_s;
    /**
     * Averaging time of the rate before its least and largest are taken, seconds. Default 0.1.
     */
    float survey_dynamics_rate_averaging_s;
    /**
     * Vibration that counts as a shock, m/s^2. Default 10 g.
     */
    float survey_dynamics_shock_m_s2;
    /**
     * Time for which vibration must stay below half of `shock_m_s2` to end a shock, seconds. Default 0.02.
     */
    float survey_dynamics_shock_pause_s;
} MwdConfig;

/**
 * One reading of all sensors, uncompensated, in the body frame: right-handed, z along the tool axis, down-hole; x
 * across it, to where toolfaces are counted from the hole's highside.
 */
typedef struct {
    /**
     * Time of acquisition, microseconds; strictly increasing.
     */
    uint64_t t_us;
    /**
     * Angular rate, rad/s.
     */
    float gyro_rad_s[3];
    /**
     * Specific force, m/s^2: at rest it points up, norm about 9.8.
     */
    float accel_m_s2[3];
    /**
     * Magnetic flux density, microtesla.
     */
    float mag_ut[3];
    /**
     * Temperature of the inertial sensor, degrees Celsius.
     */
    float temperature_c;
    /**
     * Sum of `MWD_SAMPLE_...`; 0 for a sample without faults.
     */
    uint32_t flags;
} MwdSample;

/**
 * Attitude of the tool at one time, with 1-sigma uncertainties.
 */
typedef struct {
    /**
     * Body to north-east-down, scalar first, unit norm.
     */
    float q[4];
    /**
     * Angle of the tool axis from the vertical, radians, 0 to pi.
     */
    float inclination_rad;
    /**
     * Azimuth of the tool axis, radians, 0 to 2 pi; magnetic, or true when a declination is configured.
     */
    float azimuth_rad;
    /**
     * Gravity toolface, radians, 0 to 2 pi, clockwise looking down-hole.
     */
    float gravity_toolface_rad;
    /**
     * Magnetic toolface, radians, 0 to 2 pi.
     */
    float magnetic_toolface_rad;
    /**
     * 1-sigma of the inclination, radians.
     */
    float sigma_inclination_rad;
    /**
     * 1-sigma of the azimuth, radians.
     */
    float sigma_azimuth_rad;
    /**
     * 1-sigma of the toolface that applies: gravity, or magnetic near the vertical, radians.
     */
    float sigma_toolface_rad;
    /**
     * Sum of `MWD_ATTITUDE_...`.
     */
    uint32_t flags;
} MwdAttitude;

/**
 * Output of one sample.
 */
typedef struct {
    /**
     * Time of validity, microseconds.
     */
    uint64_t t_us;
    /**
     * Compensated body rate relative to the earth, rad/s.
     */
    float rate_rad_s[3];
    /**
     * 1 if there is an attitude; 0 before the first gravity reading has aligned the filter.
     */
    uint32_t has_attitude;
    /**
     * The attitude; zeros without one.
     */
    MwdAttitude attitude;
} MwdOutput;

/**
 * Gyro model: `w = P (w_raw - b)`.
 */
typedef struct {
    /**
     * Matrix P, row by row.
     */
    float p[9];
    /**
     * Bias b, rad/s.
     */
    float b_rad_s[3];
} MwdGyroModel;

/**
 * Result of one window.
 */
typedef struct {
    /**
     * Beginning of the window, microseconds.
     */
    uint64_t t_start_us;
    /**
     * Last sample of the window, microseconds.
     */
    uint64_t t_end_us;
    /**
     * First sample to which the result applies, microseconds; `UINT64_MAX` without a result.
     */
    uint64_t t_effect_us;
    /**
     * `MWD_ACCEPTED`, or `MWD_REFUSED_...`: P stays, and only the bias may have moved.
     */
    uint32_t decision;
    /**
     * Numbers of the refusal, as its macro says; 0 without.
     */
    float refusal[2];
    /**
     * `MWD_SEARCH_...`.
     */
    uint32_t search;
    /**
     * Cost evaluations spent by the search.
     */
    uint32_t evaluations;
    /**
     * Cost of the model flown so far, on this window; NaN without anything to evaluate.
     */
    float cost_before;
    /**
     * Cost of `fitted` on this window; NaN without anything to evaluate.
     */
    float cost_after;
    /**
     * Decrease of the cost of the estimator's mean by the search; NaN without a search.
     */
    float cost_gained_by_search;
    /**
     * Twelve parameters from the samples so far, accepted or not.
     */
    MwdGyroModel fitted;
    /**
     * Bias alone, with the factory's P.
     */
    MwdGyroModel bias_only;
    /**
     * Model that flies from `t_effect_us` on.
     */
    MwdGyroModel flown;
    /**
     * 1-sigma of P, row by row, then of b in rad/s.
     */
    float sigma[12];
    /**
     * Covariance of P's nine elements: lower triangle, row by row.
     */
    float p_covariance[45];
    /**
     * 1 for each of the twelve parameters that was observed.
     */
    uint8_t observable[12];
    /**
     * Number of independent directions of the twelve that are observed.
     */
    uint8_t rank;
    /**
     * Directions of P's nine that the data decide.
     */
    uint8_t directions_decided;
    /**
     * Seconds of rest in this window.
     */
    float rest_s;
    /**
     * Seconds of motion since the start that `fitted` comes from.
     */
    float motion_s;
    /**
     * Mean squared innovation over its degrees of freedom.
     */
    float innovation_nis;
    /**
     * Change of the flown model as error of a whole turn about an axis, degrees.
     */
    float deg_per_turn;
    /**
     * Widths of the magnetometer's shape, the hard iron, the accelerometer's matrix, the magnetometer's misalignment
     * and the accelerometer's bias, over the data sheets'.
     */
    float widths[5];
} MwdWindow;

/**
 * Counters since the configuration; every loss is counted in one of them.
 */
typedef struct {
    /**
     * Samples taken.
     */
    uint64_t samples;
    /**
     * Samples refused because of their time.
     */
    uint32_t out_of_order;
    /**
     * Steps of time over three nominal periods, steps back, and more than three refused samples in a row.
     */
    uint32_t gaps;
    /**
     * Samples with a clipped sensor.
     */
    uint32_t clipped;
    /**
     * Samples without a gyro reading.
     */
    uint32_t gyro_missing;
    /**
     * Updates whose result was not ready in time: `mwd_probe_poll` was called too seldom.
     */
    uint32_t overruns;
    /**
     * Reports of windows that were dropped because none was polled.
     */
    uint32_t reports_lost;
    /**
     * Diagnoses that were dropped because none was taken; this interface takes none.
     */
    uint32_t diagnoses_lost;
    /**
     * Increments that the estimator dropped because it was not polled.
     */
    uint32_t increments_lost;
} MwdCounters;

/**
 * Physical error of a sensor that was found and is taken out of its readings.
 */
typedef struct {
    /**
     * Name, for instance `gyro_bias_temperature`.
     */
    char name[MWD_NAME_SIZE];
    /**
     * Number of parameters.
     */
    uint32_t parameters;
    /**
     * Values of the parameters, SI (field: microtesla); 0 beyond their number.
     */
    float value[9];
    /**
     * 1-sigma of each.
     */
    float sigma[9];
} MwdEffect;

/**
 * Interval in which a magnet was on the probe, an offset of the field that turns with it.
 */
typedef struct {
    /**
     * Time at which the offset came, microseconds.
     */
    uint64_t from_us;
    /**
     * Time at which it left or changed, microseconds; `UINT64_MAX` while it lasts.
     */
    uint64_t to_us;
    /**
     * Offset in the calibrated field, body frame, microtesla.
     */
    float offset_ut[3];
    /**
     * 1-sigma of each axis, microtesla.
     */
    float sigma_ut[3];
    /**
     * `MWD_FIELD_...`: use of the field meanwhile.
     */
    uint32_t field_use;
} MwdHardIronInterval;

/**
 * Value with its standard deviation, in the unit that the field's name ends with; both NaN if it is not known.
 */
typedef struct {
    /**
     * Value.
     */
    float value;
    /**
     * Standard deviation.
     */
    float sigma;
} MwdUncertain;

/**
 * Survey: the tool's direction, and the earth as its sensors see it.
 */
typedef struct {
    /**
     * Time of its first sample, microseconds.
     */
    uint64_t t_start_us;
    /**
     * Time of its last sample, microseconds.
     */
    uint64_t t_end_us;
    /**
     * Angle of the tool axis from the vertical, radians.
     */
    MwdUncertain inclination_rad;
    /**
     * Azimuth of the tool axis from magnetic north, radians.
     */
    MwdUncertain magnetic_azimuth_rad;
    /**
     * Azimuth from true north, radians.
     */
    MwdUncertain true_azimuth_rad;
    /**
     * Azimuth from grid north, radians.
     */
    MwdUncertain grid_azimuth_rad;
    /**
     * Gravity toolface, radians, clockwise looking down-hole.
     */
    MwdUncertain gravity_toolface_rad;
    /**
     * Magnetic toolface, radians.
     */
    MwdUncertain magnetic_toolface_rad;
    /**
     * Total gravity, m/s^2.
     */
    MwdUncertain gravity_m_s2;
    /**
     * Total field, microtesla.
     */
    MwdUncertain field_ut;
    /**
     * Dip below the horizon, radians.
     */
    MwdUncertain dip_rad;
    /**
     * Mean temperature, degrees Celsius; NaN if it is not known.
     */
    float temperature_c;
    /**
     * 1 if the magnetic toolface applies, 0 for the gravity toolface.
     */
    uint32_t magnetic_toolface_applies;
    /**
     * 1 if the tool turned about its axis.
     */
    uint32_t rotating;
    /**
     * `MWD_GRADE_...`.
     */
    uint32_t grade;
} MwdSurvey;

/**
 * Findings of a mounting check.
 */
typedef struct {
    /**
     * `MWD_TURN_...` of the turns that were seen well enough to judge.
     */
    uint32_t seen;
    /**
     * Those of them on which the sensors do not agree: a sign, a unit or an axis is wrong.
     */
    uint32_t wrong;
    /**
     * Total specific force of the last tenth of a second, m/s^2: gravity at rest; NaN if it is not known.
     */
    float gravity_m_s2;
    /**
     * Total field of the last tenth of a second, microtesla: the earth's; NaN if it is not known.
     */
    float field_ut;
} MwdMounting;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Fills a configuration with the defaults. Give it `MWD_CONFIG_VERSION` and `sizeof` the configuration: with those of
 * another header than the library's nothing is written, and it returns `MWD_STATUS_ERROR_VERSION`.
 *
 * Pointers:
 * `config` is NULL or points to `bytes` bytes.
 */
MwdStatus mwd_config_default(MwdConfig *config,
                             uint32_t version,
                             size_t bytes);

/**
 * Checks every field of a configuration. `reason` takes a text such as `earth.dip_rad must be -pi/2 to pi/2`, cut
 * off after `reason_bytes - 1` bytes and ended by a zero; of a valid configuration it is empty. The dots are
 * underscores in `MwdConfig`.
 *
 * Pointers:
 * `config` is NULL or points to an `MwdConfig`; `reason` is NULL or points to `reason_bytes` bytes.
 */
MwdStatus mwd_config_validate(const MwdConfig *config,
                              char *reason,
                              size_t reason_bytes);

/**
 * Makes a probe without a configuration in `storage`, which has at least `MWD_PROBE_SIZE` bytes and the alignment
 * `MWD_PROBE_ALIGN`, and points `probe` to it.
 *
 * Pointers:
 * `storage` is NULL or leads to `bytes` bytes that nothing else uses while the probe lives; `probe` is NULL or leads
 * to a pointer.
 */
MwdStatus mwd_probe_init(void *storage,
                         size_t bytes,
                         MwdProbe **probe);

/**
 * Checks a configuration and starts anew from it: everything learnt, found or counted before is forgotten. With an
 * error the probe stays as it was.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `config` is NULL or leads to an `MwdConfig`.
 */
MwdStatus mwd_probe_configure(MwdProbe *probe,
                              const MwdConfig *config);

/**
 * Lets nothing new take effect from a sample time on: the last window ends one latency before it, and its result lands
 * on it. Call it after `mwd_probe_configure` and two latencies ahead; it lasts until the next configuration.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`.
 */
MwdStatus mwd_probe_freeze(MwdProbe *probe,
                           uint64_t at_us);

/**
 * Takes one sample and writes its output. `MWD_STATUS_NOTHING`: the sample was not taken because of its time, and is
 * counted; `output` is as it was.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `sample` and `output` are NULL or lead to such structs.
 */
MwdStatus mwd_probe_push(MwdProbe *probe,
                         const MwdSample *sample,
                         MwdOutput *output);

/**
 * Does about `budget` units of identification work, of up to 500 cycles each. Call it after each sample with
 * `mwd_probe_poll_budget`. `MWD_STATUS_OK`: a window is reported in `window`; `MWD_STATUS_NOTHING`: none is ready.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `window` is NULL or leads to such a struct.
 */
MwdStatus mwd_probe_poll(MwdProbe *probe,
                         uint32_t budget,
                         MwdWindow *window);

/**
 * Returns the budget for `mwd_probe_poll` after each sample with which every result is ready when it is due; 0 before
 * a configuration.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`.
 */
uint32_t mwd_probe_poll_budget(const MwdProbe *probe);

/**
 * Writes the gyro model that flies.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `model` is NULL or leads to such a struct.
 */
MwdStatus mwd_probe_gyro_model(const MwdProbe *probe, MwdGyroModel *model);

/**
 * Writes the counters.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `counters` is NULL or leads to such a struct.
 */
MwdStatus mwd_probe_counters(const MwdProbe *probe, MwdCounters *counters);

/**
 * Writes the effects that are taken out, at most `room` of them, and their number to `count`;
 * `MWD_MAX_EFFECTS` is enough room for all. `MWD_STATUS_ERROR_TOO_SMALL`: there are more than `room`.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `effects` is NULL or leads to `room` such structs; `count` is NULL or
 * leads to a number.
 */
MwdStatus mwd_probe_effects(const MwdProbe *probe,
                            MwdEffect *effects,
                            size_t room,
                            size_t *count);

/**
 * Writes a magnet's interval when it has begun, and again when it has ended. Call it after each sample.
 * `MWD_STATUS_NOTHING`: there is no news.
 *
 * Pointers:
 * `probe` is NULL or from `mwd_probe_init`; `interval` is NULL or leads to such a struct.
 */
MwdStatus mwd_probe_take_hard_iron_interval(MwdProbe *probe,
                                            MwdHardIronInterval *interval);

/**
 * Makes a surveyor without a configuration in `storage`, which has at least `MWD_SURVEYOR_SIZE` bytes and the
 * alignment `MWD_SURVEYOR_ALIGN`, and points `surveyor` to it.
 *
 * Pointers:
 * `storage` is NULL or leads to `bytes` bytes that nothing else uses while the surveyor lives; `surveyor` is NULL or
 * leads to a pointer.
 */
MwdStatus mwd_surveyor_init(void *storage,
                            size_t bytes,
                            MwdSurveyor **surveyor);

/**
 * Checks a configuration and starts anew from its fields `earth_...` and `survey_...`.
 *
 * Pointers:
 * `surveyor` is NULL or from `mwd_surveyor_init`; `config` is NULL or leads to an `MwdConfig`.
 */
MwdStatus mwd_surveyor_configure(MwdSurveyor *surveyor, const MwdConfig *config);

/**
 * Takes a sample that was just pushed into `probe` and gave `output`. `news` becomes the sum of
 * `MWD_SURVEY_STATIONARY` and `MWD_SURVEY_ROTATING` for what it completed; `mwd_surveyor_latest` has it then.
 *
 * Pointers:
 * `surveyor` and `probe` are NULL or from their `_init`; the other pointers are NULL or lead to what their type says.
 */
MwdStatus mwd_surveyor_push(MwdSurveyor *surveyor,
                            const MwdProbe *probe,
                            const MwdSample *sample,
                            const MwdOutput *output,
                            uint32_t *news);

/**
 * Writes the latest survey of a kind, `MWD_SURVEY_...`. `MWD_STATUS_NOTHING`: there is none yet.
 *
 * Pointers:
 * `surveyor` is NULL or from `mwd_surveyor_init`; `survey` is NULL or leads to such a struct.
 */
MwdStatus mwd_surveyor_latest(const MwdSurveyor *surveyor, uint32_t kind, MwdSurvey *survey);

/**
 * Makes a mounting check that has seen nothing in `storage`, which has at least `MWD_MOUNTING_CHECK_SIZE` bytes and
 * the alignment `MWD_MOUNTING_CHECK_ALIGN`, and points `check` to it.
 *
 * Pointers:
 * `storage` is NULL or leads to `bytes` bytes that nothing else uses while the check lives; `check` is NULL or leads
 * to a pointer.
 */
MwdStatus mwd_mounting_check_init(void *storage,
                                  size_t bytes,
                                  MwdMountingCheck **check);

/**
 * Takes a sample that was just pushed into `probe`, and writes what turns have shown. While sensors do not agree on a
 * turn, `probe` accepts no new gyro model and no survey is good. Turn the probe by hand about each of its axes, a
 * quarter there and back, twice, each quarter in about two seconds.
 *
 * Pointers:
 * `check` and `probe` are NULL or from their `_init`; `sample` and `mounting` are NULL or lead to such structs.
 */
MwdStatus mwd_mounting_check_push(MwdMountingCheck *check,
                                  MwdProbe *probe,
                                  const MwdSample *sample,
                                  MwdMounting *mounting);

/**
 * Makes a filter that was not started in `storage`, which has at least `MWD_ATTITUDE_FILTER_SIZE` bytes and the
 * alignment `MWD_ATTITUDE_FILTER_ALIGN`, and points `filter` to it.
 *
 * Pointers:
 * `storage` is NULL or leads to `bytes` bytes that nothing else uses while the filter lives; `filter` is NULL or leads
 * to a pointer.
 */
MwdStatus mwd_attitude_filter_init(void *storage,
                                   size_t bytes,
                                   MwdAttitudeFilter **filter);

/**
 * Checks a configuration and starts anew from its fields `earth_...`, `attitude_...` and `identification_motion`, and
 * from whether `latency_gyro_s` and `latency_mag_s` are known. A known delay is one that the caller has taken out of
 * rate and field; one that is NaN widens the deviations while the tool turns.
 *
 * Pointers:
 * `filter` is NULL or from `mwd_attitude_filter_init`; `config` is NULL or leads to an `MwdConfig`.
 */
MwdStatus mwd_attitude_filter_start(MwdAttitudeFilter *filter,
                                    const MwdConfig *config);

/**
 * Takes one sample: turns by a compensated rate for `dt_s` seconds, then compares with the vectors, then writes the
 * attitude. `accel_m_s2` and `mag_ut` are NULL where the sensor gave no reading. `MWD_STATUS_NOTHING`: no gravity has
 * aligned the filter yet.
 *
 * Pointers:
 * `filter` is NULL or from `mwd_attitude_filter_init`; `rate_rad_s`, `accel_m_s2` and `mag_ut` are NULL or lead to
 * three numbers; `attitude` is NULL or leads to such a struct.
 */
MwdStatus mwd_attitude_filter_push(MwdAttitudeFilter *filter,
                                   float dt_s,
                                   const float *rate_rad_s,
                                   const float *accel_m_s2,
                                   const float *mag_ut,
                                   MwdAttitude *attitude);

/**
 * Frame of all bits of an output (kind 3), with the zero that ends it. `written` becomes its length.
 *
 * Pointers:
 * `frame` is NULL or leads to `bytes` bytes that hold some value; the other pointers are NULL or lead to what their
 * type says.
 */
MwdStatus mwd_frame_output(const MwdOutput *output,
                           uint16_t sequence,
                           uint8_t *frame,
                           size_t bytes,
                           size_t *written);

/**
 * Frame of the quantised angles of an output (kind 2).
 *
 * Pointers:
 * As of `mwd_frame_output`.
 */
MwdStatus mwd_frame_attitude(const MwdOutput *output,
                             uint16_t sequence,
                             uint8_t *frame,
                             size_t bytes,
                             size_t *written);

/**
 * Frame of a raw sample (kind 4); `number` counts the samples since the start.
 *
 * Pointers:
 * As of `mwd_frame_output`.
 */
MwdStatus mwd_frame_sample(const MwdSample *sample,
                           uint32_t number,
                           uint16_t sequence,
                           uint8_t *frame,
                           size_t bytes,
                           size_t *written);

/**
 * Frame of a window's report (kind 7); `temperature_c` is the window's mean, NaN if it is not known.
 *
 * Pointers:
 * As of `mwd_frame_output`.
 */
MwdStatus mwd_frame_window(const MwdWindow *window,
                           float temperature_c,
                           uint16_t sequence,
                           uint8_t *frame,
                           size_t bytes,
                           size_t *written);

/**
 * Frame of the latest survey of mean vectors (kind 5): `kind` is `MWD_SURVEY_STATIONARY` or `MWD_SURVEY_ROTATING`.
 * `MWD_STATUS_NOTHING`: there is none yet.
 *
 * Pointers:
 * `surveyor` is NULL or from `mwd_surveyor_init`; the others as of `mwd_frame_output`.
 */
MwdStatus mwd_frame_survey(const MwdSurveyor *surveyor,
                           uint32_t kind,
                           uint16_t sequence,
                           uint8_t *frame,
                           size_t bytes,
                           size_t *written);

/**
 * Frame with which a probe begins (kind 1): its unique number of `MWD_PROBE_ID_SIZE` bytes and its configuration.
 * A receiver needs it to replay a recording.
 *
 * Pointers:
 * `probe_id` is NULL or leads to `MWD_PROBE_ID_SIZE` bytes; the others as of `mwd_frame_output`.
 */
MwdStatus mwd_frame_boot(const MwdConfig *config,
                         const uint8_t *probe_id,
                         uint16_t sequence,
                         uint8_t *frame,
                         size_t bytes,
                         size_t *written);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MEERKAT_MWD_H */
