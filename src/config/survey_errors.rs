//! Error model of surveys: the sensor terms of the ISCWSA MWD error model.

use super::{ConfigError, all_positive};

/// Errors left in the calibrated sensors and in the reference field, one standard deviation each, by the
/// terms of the ISCWSA MWD error model. Sensor terms are those of its revisions 4 and 5, AMIL too; DEC and
/// DBH are those of revision 4 without its random parts DECR and DBHR (revision 5 splits them by source). MFI
/// and MDI belong to the model's axial-correction variants; their values here are those usually quoted from
/// H. Williamson, SPE 67616 (2000). They enter every sigma that a survey states, but angles
/// of continuous surveys, which have the attitude filter's.
///
/// A survey cannot see the tool's misalignment in the hole (XYM1 to XYM4, SAG) or the depth; those terms are
/// absent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SurveyErrors {
    /// Bias of each accelerometer axis, m/s^2. Default 0.004 (ABXY, ABZ).
    pub accel_bias_m_s2: f32,
    /// Scale factor of each accelerometer axis, dimensionless. Default 0.0005 (ASXY, ASZ).
    pub accel_scale: f32,
    /// Bias of each magnetometer axis, microtesla. Default 0.07 (MBXY, MBZ: 70 nT).
    pub mag_bias_ut: f32,
    /// Scale factor of each magnetometer axis, dimensionless. Default 0.0016 (MSXY, MSZ).
    pub mag_scale: f32,
    /// Field of the drill string along the tool axis, microtesla; 0: none. Default 0.22 (AMIL of revision 4:
    /// 220 nT).
    pub axial_interference_ut: f32,
    /// Error of the reference declination, radians: the part that does not depend on the field. Default 0.36 deg (DEC).
    pub declination_rad: f32,
    /// Error of the reference declination, radian microtesla: the part to be divided by the horizontal field. Default
    /// 5,000 deg nT (DBH).
    pub declination_rad_ut: f32,
    /// Error of the reference total field, microtesla. Default 0.13 (MFI: 130 nT).
    pub total_field_ut: f32,
    /// Error of the reference dip, radians. Default 0.20 deg (MDI).
    pub dip_rad: f32,
    /// Uncorrected delay between the accelerometer's and the magnetometer's reading, seconds; it turns the azimuth
    /// measured while rotating. Default 0.001: a tenth of a 100 Hz magnetometer's hold, 10 ms.
    pub mag_timing_s: f32,
}

impl SurveyErrors {
    /// All-zero settings of a static before it is configured.
    pub(super) const UNSET: Self = Self {
        accel_bias_m_s2: 0.0,
        accel_scale: 0.0,
        mag_bias_ut: 0.0,
        mag_scale: 0.0,
        axial_interference_ut: 0.0,
        declination_rad: 0.0,
        declination_rad_ut: 0.0,
        total_field_ut: 0.0,
        dip_rad: 0.0,
        mag_timing_s: 0.0,
    };

    pub(super) fn validate(&self) -> Result<(), ConfigError> {
        all_positive(
            [
                self.accel_bias_m_s2,
                self.accel_scale,
                self.mag_bias_ut,
                self.mag_scale,
                self.declination_rad,
                self.declination_rad_ut,
                self.total_field_ut,
                self.dip_rad,
                self.mag_timing_s,
            ],
            &[
                "survey.errors.accel_bias_m_s2",
                "survey.errors.accel_scale",
                "survey.errors.mag_bias_ut",
                "survey.errors.mag_scale",
                "survey.errors.declination_rad",
                "survey.errors.declination_rad_ut",
                "survey.errors.total_field_ut",
                "survey.errors.dip_rad",
                "survey.errors.mag_timing_s",
            ],
        )?;
        let interference = self.axial_interference_ut;
        if interference.is_finite() && interference >= 0.0 {
            Ok(())
        } else {
            Err(ConfigError { field: "survey.errors.axial_interference_ut", must_be: "finite and not negative" })
        }
    }
}

impl Default for SurveyErrors {
    fn default() -> Self {
        Self {
            accel_bias_m_s2: 0.004,
            accel_scale: 0.000_5,
            mag_bias_ut: 0.07,
            mag_scale: 0.001_6,
            axial_interference_ut: 0.22,
            declination_rad: 0.36_f32.to_radians(),
            declination_rad_ut: 5.0_f32.to_radians(),
            total_field_ut: 0.13,
            dip_rad: 0.2_f32.to_radians(),
            mag_timing_s: 0.001,
        }
    }
}
