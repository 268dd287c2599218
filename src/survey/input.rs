use crate::attitude::Attitude;

/// What one sample gives to surveys. Vectors in tool axes; `None`: not read, or not to be believed.
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
    /// The accelerometer as it reads, m/s^2, for the six-axis record.
    pub raw_accel_m_s2: [f32; 3],
    /// The magnetometer as it reads, microtesla, for the six-axis record.
    pub raw_mag_ut: [f32; 3],
    /// Whether an accelerometer axis is at its full scale.
    pub accel_clipped: bool,
    /// Temperature, degrees Celsius.
    pub temperature_c: Option<f32>,
    /// The attitude filter's output.
    pub attitude: Option<Attitude>,
}

impl SurveyInput {
    /// The same with every vector that is not finite taken for missing.
    pub(super) fn sanitised(&self) -> Self {
        let finite = |v: Option<[f32; 3]>| v.filter(|v| v.iter().all(|x| x.is_finite()));
        let raw = |v: [f32; 3]| if v.iter().all(|x| x.is_finite()) { v } else { [0.0; 3] };
        Self {
            rate_rad_s: finite(self.rate_rad_s),
            force_m_s2: finite(self.force_m_s2),
            field_ut: finite(self.field_ut),
            raw_accel_m_s2: raw(self.raw_accel_m_s2),
            raw_mag_ut: raw(self.raw_mag_ut),
            temperature_c: self.temperature_c.filter(|x| x.is_finite()),
            ..*self
        }
    }
}
