//! Settings of the estimator: noise of the motion and errors of the sensors.

use super::{
    candidates::Rules,
    columns::{ACCEL_BIAS, ACCEL_LAG, ACCEL_MATRIX, BIAS, GLOBALS, Group, HARD_IRON, MAG_LAG, MAG_SHAPE, MAG_TURN, P},
    widths::Widths,
};
use crate::{
    compensation::GyroModel,
    config::{Config, IdentificationConfig, Motion},
    rotation::sine_and_cosine,
};

/// Least noise of a gyro, rad/s/rtHz: none is better than 2e-4 deg per root hour.
const LEAST_GYRO_NOISE: f32 = 5e-8;

/// Deviations of the sensors' noise and bounds of the motion. They are configured, because evidence cannot choose them:
/// for motion by hand it would prefer a drill string's constants by 1,500 log units, and be wrong by a factor of 14 to
/// 58 in variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Noise of the rotation, rad per root second: the gyro's, and by hand at least what the model leaves out.
    pub rotation_rad_rts: f32,
    /// Further noise of the rotation, as a share of the angle that was turned.
    pub rotation_share: f32,
    /// Noise of a node's mean field, as a share of the norm.
    pub field_share: f32,
    /// Factor on `field_share` at rest.
    pub field_at_rest: f32,
    /// Walk of the earth field where the probe is, share of the norm per root second of motion.
    pub field_walk_rts: f32,
    /// Walk of each element of P, per root second.
    pub p_walk_rts: f32,
    /// Walk of the gyro's bias, rad/s per root second.
    pub bias_walk_rad_s_rts: f32,
    /// Bound of the position about where the probe is held, metres.
    pub position_m: f32,
    /// Bound of the velocity, m/s.
    pub velocity_m_s: f32,
    /// Noise of a node's increment of velocity, m/s.
    pub velocity_increment_m_s: f32,
    /// Noise of white acceleration, m/s per root second, on velocity and position alike.
    pub acceleration_m_s_rts: f32,
    /// Degrees of freedom of Student's t of the acceleration; 0: Gaussian.
    pub acceleration_freedom: f32,
    /// Degrees of freedom of Student's t of field and rotation.
    pub freedom: f32,
    /// True if the earth's field is the same over the whole path. Then a field is disturbed if its norm differs from
    /// that of the estimated field, and if it contradicts by a turn alone the gyro is wrong. Else a field is disturbed
    /// if its norm differs from the mean of earlier norms, each calibrated as it was at its time; this also inflates
    /// the noise as long as the calibration moves.
    pub field_is_even: bool,
    /// True if predicted gravity, not the read force, multiplies the accelerometer's errors: where vibration is larger
    /// than gravity.
    pub predicted_gravity: bool,
}

impl Noise {
    /// Noise of a sensor moved by hand.
    pub const HAND: Self = Self {
        rotation_rad_rts: 5.236e-4, // 0.03 deg
        rotation_share: 0.003,
        field_share: 0.006,
        field_at_rest: 0.3,
        field_walk_rts: 0.01,
        p_walk_rts: 2e-4,             // 1e-4 to 3e-4 are as good
        bias_walk_rad_s_rts: 5.24e-5, // 3e-3 deg/s: a tighter one is overconfident by 17 % on real recordings
        position_m: 0.3,
        velocity_m_s: 1.0,
        velocity_increment_m_s: 0.01,
        acceleration_m_s_rts: 0.0,
        acceleration_freedom: 0.0,
        freedom: 5.0,
        field_is_even: false,
        predicted_gravity: false,
    };

    /// Noise of a probe in a drill string.
    pub const DRILL_STRING: Self = Self {
        rotation_rad_rts: 1.75e-4,
        rotation_share: 5e-5,
        field_share: 0.000_4,
        field_at_rest: 0.3,
        field_walk_rts: 0.000_4,
        p_walk_rts: 2e-5,          // 0.007 %/K (LSM6DSO) at a kelvin in a quarter of a minute
        bias_walk_rad_s_rts: 2e-5, // 0.01 deg/s/K (LSM6DSO)
        position_m: 0.01,
        velocity_m_s: 0.1,
        velocity_increment_m_s: 0.01,
        acceleration_m_s_rts: 0.12,
        acceleration_freedom: 3.0,
        freedom: 5.0,
        field_is_even: true,
        predicted_gravity: true,
    };

    /// Noise by hand, with vectors that come from a reference attitude of 0.1 deg (an optical one): the errors that are
    /// left are the gyro's.
    pub const REFERENCE: Self = Self {
        rotation_share: 0.001,
        field_share: 0.002,
        field_at_rest: 1.0,
        field_walk_rts: 0.000_4,
        velocity_increment_m_s: 0.01,
        ..Self::HAND
    };

    /// All zero, to initialise a static.
    pub(super) const UNSET: Self = Self {
        rotation_rad_rts: 0.0,
        rotation_share: 0.0,
        field_share: 0.0,
        field_at_rest: 0.0,
        field_walk_rts: 0.0,
        p_walk_rts: 0.0,
        bias_walk_rad_s_rts: 0.0,
        position_m: 0.0,
        velocity_m_s: 0.0,
        velocity_increment_m_s: 0.0,
        acceleration_m_s_rts: 0.0,
        acceleration_freedom: 0.0,
        freedom: 0.0,
        field_is_even: false,
        predicted_gravity: false,
    };
}

/// Settings before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Nominal sample period, seconds.
    pub sample_period_s: f32,
    /// True if the gyro's readings are of an instant, not means over the interval that they end.
    pub is_instant: bool,
    /// Gravity, m/s^2.
    pub gravity_m_s2: f32,
    /// Centre of the prior of P and b.
    pub factory: GyroModel,
    /// Noise and bounds.
    pub noise: Noise,
    /// Width of the prior of each column, in its own unit; 0: the column is not in use.
    pub sigma: [f32; GLOBALS],
    /// Widths of the nuisances' priors that the posterior is averaged over.
    pub widths: Widths,
    /// Deviation of the rate below which, on every axis, the probe may be at rest, rad/s.
    pub rest_deviation_rad_s: f32,
    /// The largest bias, rad/s: a steady rate above it is rotation.
    pub most_bias_rad_s: f32,
    /// Rules by which an effect is claimed.
    pub rules: Rules,
    /// Field of the earth as it is declared, where it is the same over the whole path.
    pub reference: Option<Reference>,
}

/// Field of the earth from a reference: norm and sine of the dip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Norm, microtesla.
    pub norm_ut: f32,
    /// Deviation of the reference's norm, microtesla.
    pub norm_sigma_ut: f32,
    /// Sine of the dip below the horizontal.
    pub dip_sine: f32,
    /// Deviation of the dip's sine.
    pub dip_sine_sigma: f32,
}

impl Reference {
    fn new(config: &Config) -> Option<Self> {
        let (norm_ut, dip_rad) = (config.earth.magnetic_field_ut?, config.earth.dip_rad?);
        let errors = &config.survey.errors;
        let (dip_sine, dip_cosine) = sine_and_cosine(dip_rad);
        // At the poles of the dip the sine does not change in the first order.
        let second = 0.5 * errors.dip_rad * errors.dip_rad;
        Some(Self {
            norm_ut,
            norm_sigma_ut: errors.total_field_ut,
            dip_sine,
            dip_sine_sigma: libm::fabsf(dip_cosine) * errors.dip_rad + second,
        })
    }
}

impl Settings {
    /// All zero, to initialise a static.
    pub const UNSET: Self = Self {
        sample_period_s: 0.0,
        is_instant: false,
        gravity_m_s2: 0.0,
        factory: GyroModel::UNSET,
        noise: Noise::UNSET,
        sigma: [0.0; GLOBALS],
        widths: Widths::UNSET,
        rest_deviation_rad_s: 0.0,
        most_bias_rad_s: 0.0,
        rules: Rules { least: 0.0, with_nuisances: false },
        reference: None,
    };

    /// Settings that follow from the configuration.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let id = &config.identification;
        let drilling = id.motion == Motion::DrillString;
        let mut sigma = [0.0; GLOBALS];
        put(&mut sigma, &MAG_LAG, id, 1.0);
        put(&mut sigma, &ACCEL_LAG, id, 1.0);
        let widths = if drilling { Widths::DRILL_STRING } else { Widths::HAND };
        // By hand the filter's widths are three to four times the data sheets'; they are narrowed when the posterior is
        // asked for.
        let [of_shape, of_iron, of_accel, of_turn, of_bias] = widths.sheet;
        put(&mut sigma, &MAG_SHAPE, id, of_shape);
        put(&mut sigma, &MAG_TURN, id, of_turn);
        put(&mut sigma, &HARD_IRON, id, of_iron);
        // On a drill string the antisymmetric part is left out, which defines the body frame; by hand the bias, which
        // the matrix holds.
        let count = if drilling { 6 } else { ACCEL_MATRIX.count };
        put(&mut sigma, &Group { count, ..ACCEL_MATRIX }, id, of_accel);
        if drilling {
            put(&mut sigma, &ACCEL_BIAS, id, of_bias);
        }
        if id.vectors_from_reference {
            // Vectors from a reference have no errors of their own. A delay that both have is the effect `gyro_lag`.
            sigma = [0.0; GLOBALS];
        }
        put(&mut sigma, &BIAS, id, 1.0);
        put(&mut sigma, &P, id, 1.0);
        let mut noise = if drilling { Noise::DRILL_STRING } else { Noise::HAND };
        let gyro = config.attitude.gyro_noise_rad_s_rthz;
        let gyro = if gyro > LEAST_GYRO_NOISE { gyro } else { LEAST_GYRO_NOISE };
        // By hand the errors that the model leaves out are no smaller.
        if drilling || gyro > noise.rotation_rad_rts {
            noise.rotation_rad_rts = gyro;
        }
        if id.vectors_from_reference {
            noise = Noise { rotation_rad_rts: noise.rotation_rad_rts, ..Noise::REFERENCE };
        }
        Self {
            sample_period_s: config.sample_period_us as f32 * 1e-6,
            is_instant: config.latency.gyro_s.is_some(),
            gravity_m_s2: config.earth.gravity_m_s2,
            factory: config.gyro,
            noise,
            sigma,
            widths,
            rest_deviation_rad_s: id.rest_gyro_deviation_rad_s,
            most_bias_rad_s: id.max_bias_rad_s,
            rules: if drilling { Rules::DRILL_STRING } else { Rules::HAND },
            reference: if noise.field_is_even && !id.vectors_from_reference { Reference::new(config) } else { None },
        }
    }
}

/// Puts the widths of a group's columns, of which the group has this share.
fn put(sigma: &mut [f32; GLOBALS], group: &Group, id: &IdentificationConfig, share: f32) {
    for (k, slot) in sigma.iter_mut().skip(group.from).take(group.count).enumerate() {
        *slot = (group.width)(id, k) / share;
    }
}
