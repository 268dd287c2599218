//! Input of surveys.

use crate::{
    attitude::Attitude,
    sample::{BEYOND_ANY_ACCEL_M_S2, BEYOND_ANY_GYRO_RAD_S, BEYOND_ANY_MAG_UT, TurnFlags},
};

/// Sample's contribution to surveys. Vectors in tool axes; `None`: not read, or unusable.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurveyInput {
    /// Time of acquisition, microseconds; increasing.
    pub t_us: u64,
    /// Compensated body rate, rad/s.
    pub rate_rad_s: Option<[f32; 3]>,
    /// Calibrated specific force, m/s^2: at rest it points up.
    pub force_m_s2: Option<[f32; 3]>,
    /// Calibrated field, microtesla.
    pub field_ut: Option<[f32; 3]>,
    /// Standard deviation on each axis of what was taken out of the force for found effects, m/s^2; 0 if nothing was.
    pub force_correction_sigma_m_s2: [f32; 3],
    /// Standard deviation on each axis of what was taken out of the field for found effects and magnets, microtesla; 0
    /// if nothing was.
    pub field_correction_sigma_ut: [f32; 3],
    /// Standard deviation of the magnetometer's delay against the rate, as far as it is not taken out, seconds;
    /// the configured error of timing is its least. A delay turns the field that a turning tool reads.
    pub mag_delay_sigma_s: f32,
    /// Raw accelerometer reading, m/s^2, for the six-axis record.
    pub raw_accel_m_s2: [f32; 3],
    /// Raw magnetometer reading, microtesla, for the six-axis record.
    pub raw_mag_ut: [f32; 3],
    /// True if an accelerometer axis is at its full scale.
    pub accel_clipped: bool,
    /// Turns about which the sensors do not agree, [`MountingCheck::wrong`](crate::sensors::MountingCheck::wrong):
    /// while there are any, no survey is good.
    pub mounting_wrong: TurnFlags,
    /// Temperature, degrees Celsius.
    pub temperature_c: Option<f32>,
    /// Output of the attitude filter.
    pub attitude: Option<Attitude>,
}

impl SurveyInput {
    /// Returns the input with every vector set missing that is not finite or beyond any sensor, or whose correction's
    /// sigma is; so is a field whose delay is uncertain by a second or more.
    pub(super) fn sanitised(&self) -> Self {
        // A NaN is not below the limit either.
        let sound = |v: &[f32; 3], limit: f32| v.iter().all(|x| libm::fabsf(*x) < limit);
        let both =
            |v: Option<[f32; 3]>, sigma: &[f32; 3], limit: f32| v.filter(|v| sound(v, limit) && sound(sigma, limit));
        let raw = |v: [f32; 3], limit: f32| if sound(&v, limit) { v } else { [0.0; 3] };
        Self {
            rate_rad_s: self.rate_rad_s.filter(|v| sound(v, BEYOND_ANY_GYRO_RAD_S)),
            force_m_s2: both(self.force_m_s2, &self.force_correction_sigma_m_s2, BEYOND_ANY_ACCEL_M_S2),
            field_ut: both(self.field_ut, &self.field_correction_sigma_ut, BEYOND_ANY_MAG_UT)
                .filter(|_| (0.0..1.0).contains(&self.mag_delay_sigma_s)),
            raw_accel_m_s2: raw(self.raw_accel_m_s2, BEYOND_ANY_ACCEL_M_S2),
            raw_mag_ut: raw(self.raw_mag_ut, BEYOND_ANY_MAG_UT),
            temperature_c: self.temperature_c.filter(|x| x.is_finite()),
            ..*self
        }
    }
}
