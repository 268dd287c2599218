use super::MultiStationSettings;
use crate::config::SurveyErrors;

/// Number of errors that an analysis estimates.
pub const PARAMETERS: usize = 16;

/// Error that the stations have in common. A sensor reads (1 + scale) truth + bias on each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Parameter {
    /// Bias of the accelerometer's axis (0 x, 1 y, 2 z), m/s^2 of specific force.
    AccelBias(u8),
    /// Scale factor of the accelerometer's axis.
    AccelScale(u8),
    /// Bias of the magnetometer's axis, microtesla. The bias of z includes the drill string's field at the first
    /// station.
    MagBias(u8),
    /// Scale factor of the magnetometer's axis.
    MagScale(u8),
    /// Growth of the drill string's field along z from the first station to the last, microtesla.
    AxialGrowth,
    /// Error of the reference's gravity (true less reference), m/s^2.
    GravityReference,
    /// Error of the reference's total field, microtesla.
    FieldReference,
    /// Error of the reference's dip, radians.
    DipReference,
}

/// Index of the magnetometer's axial bias, the drill string's field at the first station included, among the
/// parameters.
pub(super) const AXIAL: usize = 8;
/// Index of the growth of the axial field among the parameters.
pub(super) const GROWTH: usize = 12;
/// Index of the reference gravity's error among the parameters; those of field and dip follow.
pub(super) const REFERENCES: usize = 13;

impl Parameter {
    /// All parameters, in the order of [`MultiStationReport::estimates`](super::MultiStationReport).
    pub const ALL: [Self; PARAMETERS] = [
        Self::AccelBias(0),
        Self::AccelBias(1),
        Self::AccelBias(2),
        Self::AccelScale(0),
        Self::AccelScale(1),
        Self::AccelScale(2),
        Self::MagBias(0),
        Self::MagBias(1),
        Self::MagBias(2),
        Self::MagScale(0),
        Self::MagScale(1),
        Self::MagScale(2),
        Self::AxialGrowth,
        Self::GravityReference,
        Self::FieldReference,
        Self::DipReference,
    ];

    /// Name, with the unit of its value at the end; a scale factor has none.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::AccelBias(0) => "accel_bias_x_m_s2",
            Self::AccelBias(1) => "accel_bias_y_m_s2",
            Self::AccelBias(_) => "accel_bias_z_m_s2",
            Self::AccelScale(0) => "accel_scale_x",
            Self::AccelScale(1) => "accel_scale_y",
            Self::AccelScale(_) => "accel_scale_z",
            Self::MagBias(0) => "mag_bias_x_ut",
            Self::MagBias(1) => "mag_bias_y_ut",
            Self::MagBias(_) => "mag_bias_z_ut",
            Self::MagScale(0) => "mag_scale_x",
            Self::MagScale(1) => "mag_scale_y",
            Self::MagScale(_) => "mag_scale_z",
            Self::AxialGrowth => "axial_growth_ut",
            Self::GravityReference => "gravity_reference_m_s2",
            Self::FieldReference => "field_reference_ut",
            Self::DipReference => "dip_reference_rad",
        }
    }

    /// Standard deviation before any station: the ISCWSA MWD error model's, as configured. For the axial growth it is
    /// that of the drill string's field itself, all of which may build up during the run. A drill string of 0
    /// microtesla still has a prior, of one nanotesla, so that every width is positive.
    #[must_use]
    pub fn prior_sigma(self, errors: &SurveyErrors, settings: &MultiStationSettings) -> f32 {
        let axial = libm::hypotf(errors.axial_interference_ut, 1e-3);
        match self {
            Self::AccelBias(_) => errors.accel_bias_m_s2,
            Self::AccelScale(_) => errors.accel_scale,
            Self::MagBias(2) => libm::hypotf(errors.mag_bias_ut, axial),
            Self::MagBias(_) => errors.mag_bias_ut,
            Self::MagScale(_) => errors.mag_scale,
            Self::AxialGrowth => axial,
            Self::GravityReference => settings.gravity_reference_m_s2,
            Self::FieldReference => errors.total_field_ut,
            Self::DipReference => errors.dip_rad,
        }
    }
}
