//! The tool and its hole, and the configuration that knows of them.

use meerkat_mwd::{
    Config,
    config::{AttitudeConfig, IdentificationConfig, Latency, SurveyErrors, VectorErrors},
};

use testbed::{
    flight::configuration::of_trace,
    simulate::{Effects, Gyro, Hole, Random, Rotation, Scenario, ShockSettings},
    trace::Trace,
};

pub(super) const REST_S: f64 = 30.0;
const DURATION_S: f64 = 93.0;

/// Remaining errors of an identified gyro: scale factors and couplings, bias, and data sheets' nonlinearity
/// and g-sensitivity, which are as large (MPU-9250 PS section 3.1: 0.1 %; MPU-6000 PS section 6.1: 0.1 deg/s
/// per g).
const GYRO_SCALE: f64 = 1e-3;
const GYRO_BIAS_DEG_S: f64 = 0.1;

/// Speed of a probe in its hole, m/s: a shock of 10 g over 5 ms gives this much until the wall takes it back;
/// vibration likewise.
const SPEED_M_S: f32 = 0.1;

pub(super) fn scenario(inclination_deg: f64, mean_rpm: f64, seed: u64) -> Scenario {
    // A stream apart from the simulator's own.
    let mut draw = Random::new(!seed);
    let model = SurveyErrors::default();
    let mut three = |sigma: f32| -> [f64; 3] { std::array::from_fn(|_| f64::from(sigma) * draw.normal()) };
    let (accel_bias, accel_scale) = (three(model.accel_bias_m_s2), three(model.accel_scale));
    let (mag_bias, mag_scale) = (three(model.mag_bias_ut), three(model.mag_scale));
    let scaled = |scale: [f64; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|r| std::array::from_fn(|c| if r == c { scale[r] } else { 0.0 }))
    };
    let [azimuth_deg, toolface_deg] = std::array::from_fn(|_| draw.between(0.0, 360.0));
    Scenario {
        duration_s: DURATION_S,
        rest_s: REST_S,
        hole: Hole { inclination_deg, azimuth_deg, ..Hole::default() },
        // Half of full stick-slip: between a steady string and one that stops.
        rotation: Rotation { mean_rpm, toolface_deg, stick_slip: 0.5, ..Rotation::default() },
        shocks: ShockSettings { per_minute: 20.0, peak_g: [5.0, 20.0], ..ShockSettings::default() },
        gyro: Gyro {
            diagonal_sigma: GYRO_SCALE,
            off_diagonal_sigma: GYRO_SCALE,
            bias_sigma_deg_s: GYRO_BIAS_DEG_S,
            ..Gyro::default()
        },
        effects: Effects {
            accel_bias_m_s2: accel_bias,
            accel_matrix: scaled(accel_scale),
            hard_iron_ut: mag_bias,
            mag_matrix: scaled(mag_scale),
            ..Effects::default()
        },
        ..Scenario::default()
    }
}

/// The configuration for such sensors.
pub(super) fn config(trace: &Trace) -> Config {
    let config = of_trace(trace);
    let model = SurveyErrors::default();
    let gravity_m_s2 = config.earth.gravity_m_s2;
    let field_ut = config.earth.magnetic_field_ut.unwrap_or(50.0);
    Config {
        latency: Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) },
        attitude: AttitudeConfig {
            // At most half of the gravity, or field, that a scale factor acts on lies across it.
            accel_sigma_m_s2: libm::hypotf(model.accel_bias_m_s2, 0.5 * model.accel_scale * gravity_m_s2),
            mag_sigma_rad: libm::hypotf(model.mag_bias_ut / field_ut, 0.5 * model.mag_scale),
            velocity_sigma_m_s: SPEED_M_S,
            gyro_scale_sigma: GYRO_SCALE as f32,
            gyro_bias_sigma_rad_s: GYRO_BIAS_DEG_S.to_radians() as f32,
            ..AttitudeConfig::default()
        },
        identification: IdentificationConfig {
            vector_errors: VectorErrors {
                mag_matrix: model.mag_scale,
                hard_iron: model.mag_bias_ut / field_ut,
                mag_lag_s: model.mag_timing_s,
                accel_matrix: model.accel_scale,
                accel_bias_m_s2: model.accel_bias_m_s2,
                accel_lag_s: model.mag_timing_s,
            },
            ..config.identification
        },
        ..config
    }
}
