/// Settings of the multi-station analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct MultiStationSettings {
    /// Noise of one station's mean force, each axis, m/s^2. Default 0.0015 (0.15 mg): a mean over 10 s of a MEMS
    /// accelerometer with 0.15 mg per root hertz has a third of this; the rest allows for a string that still moves.
    pub force_noise_m_s2: f32,
    /// Noise of one station's mean field, each axis, microtesla. Default 0.02: a magnetometer's noise of 0.3
    /// microtesla, averaged over 10 s at 25 Hz.
    pub field_noise_ut: f32,
    /// Change of the total field from station to station that the reference does not have (daily variation),
    /// microtesla, 1 sigma. Default 0.06: MFIR of the ISCWSA's OWSG tool codes, 60 nT.
    pub total_field_noise_ut: f32,
    /// Change of the dip from station to station that the reference does not have, radians, 1 sigma. Default 0.08 deg:
    /// MDIR of the OWSG tool codes.
    pub dip_noise_rad: f32,
    /// Reference gravity's error, m/s^2, 1 sigma. Default 0.005: local gravity is within some 0.5 mg of the normal
    /// one.
    pub gravity_reference_m_s2: f32,
    /// Standard deviations by which a correction must be sure to lower the error of its angle, over all stations
    /// together. Default 2.33: one correction in a hundred may raise it.
    pub harm_deviations: f32,
    /// Share of a prior's width below which an error counts as observable. Default 0.5: the stations then give at least
    /// three times the prior's information.
    pub observable_below: f32,
    /// Largest ratio of the residuals' variance to the configured noise's with which angles are corrected; up to it the
    /// noise is inflated to the residuals. Default 9: residuals of three times the noise.
    pub largest_noise_ratio: f32,
}

impl Default for MultiStationSettings {
    fn default() -> Self {
        Self {
            force_noise_m_s2: 0.001_5,
            field_noise_ut: 0.02,
            total_field_noise_ut: 0.06,
            dip_noise_rad: 0.08_f32.to_radians(),
            gravity_reference_m_s2: 0.005,
            harm_deviations: 2.33,
            observable_below: 0.5,
            largest_noise_ratio: 9.0,
        }
    }
}
