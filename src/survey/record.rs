//! Record of a survey, and the switch of its toolface.

use super::{
    Uncertain,
    north::Norths,
    six_axis::{SixAxis, SixAxisCovariance},
};
use crate::{
    attitude::{ToolAngleSigmas, ToolAngles, near_vertical, positive_angle},
    config::{Earth, SurveyConfig},
};

/// Origin of a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SurveyKind {
    /// Angles of the attitude filter at one sample.
    Continuous,
    /// Mean vectors at rest.
    Stationary,
    /// Mean vectors over whole turns.
    Rotating,
}

/// Kind of toolface that applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ToolfaceKind {
    /// Counted from the highside.
    Gravity,
    /// Counted from magnetic north, near the vertical.
    Magnetic,
}

/// Survey: the tool's direction, and the earth as its sensors see it. Tool frame: z down-hole, x at the
/// highside when the toolface is 0. All angles are 0 to 2 pi except inclination (0 to pi) and dip (below the
/// horizon, -pi/2 to pi/2).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Survey {
    /// Origin of the survey.
    pub kind: SurveyKind,
    /// Time of its first sample, microseconds.
    pub t_start_us: u64,
    /// Time of its last sample, microseconds.
    pub t_end_us: u64,
    /// Angle of the tool axis from the vertical, radians.
    pub inclination_rad: Uncertain,
    /// Azimuth of the tool axis from magnetic north, radians; `None` without a usable field or a known north.
    pub magnetic_azimuth_rad: Option<Uncertain>,
    /// Azimuth from true north; its sigma includes the declination's. `None` without a configured
    /// declination.
    pub true_azimuth_rad: Option<Uncertain>,
    /// Azimuth from grid north; its sigma includes the declination's. `None` without a configured declination
    /// and grid convergence.
    pub grid_azimuth_rad: Option<Uncertain>,
    /// Gravity toolface: angle from the highside, clockwise looking down-hole, radians, with the toolface
    /// offset; singular at the vertical. `None` while rotating.
    pub gravity_toolface_rad: Option<Uncertain>,
    /// Magnetic toolface: magnetic azimuth plus gravity toolface, radians, with the toolface offset; exact
    /// for every inclination under pi. `None` while rotating and without an azimuth.
    pub magnetic_toolface_rad: Option<Uncertain>,
    /// Toolface that applies: gravity, or magnetic near the vertical, with hysteresis from survey to survey.
    pub toolface_kind: ToolfaceKind,
    /// Total gravity |G|, m/s^2; `None` without an accelerometer reading.
    pub gravity_m_s2: Option<Uncertain>,
    /// Total field |B|, microtesla.
    pub field_ut: Option<Uncertain>,
    /// Dip below the horizon, radians.
    pub dip_rad: Option<Uncertain>,
    /// Mean temperature, degrees Celsius.
    pub temperature_c: Option<f32>,
    /// True if the tool turned about its axis.
    pub rotating: bool,
}

/// Angles from magnetic north with their sigmas, without the toolface offset.
pub(crate) struct Angles {
    pub(crate) angles: ToolAngles,
    pub(crate) sigmas: ToolAngleSigmas,
    pub(crate) north_known: bool,
    /// Horizontal field, microtesla, for the declination's error.
    pub(crate) horizontal_ut: f32,
}

impl Survey {
    /// Creates a survey of two mean vectors.
    pub(crate) fn of_six_axis(
        kind: SurveyKind,
        span_us: [u64; 2],
        six: &SixAxis,
        covariance: &SixAxisCovariance,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Self {
        let field = six.field();
        let angles = Angles {
            angles: six.angles(),
            sigmas: six.angle_sigmas(covariance),
            north_known: field.is_some(),
            horizontal_ut: field.as_ref().map_or(0.0, |field| field.horizontal_ut),
        };
        let mut survey = Self::of_angles(kind, span_us, &angles, toolface, (earth, config));
        survey.gravity_m_s2 = Some(Uncertain { value: six.gravity_m_s2(), sigma: six.gravity_sigma_m_s2(covariance) });
        if let (Some(field), Some((total, dip))) = (field, six.field_sigmas(covariance)) {
            survey.field_ut = Some(Uncertain { value: field.total_ut, sigma: total });
            survey.dip_rad = Some(Uncertain { value: field.dip_rad, sigma: dip });
        }
        survey
    }

    /// Creates a survey of known angles, without the vectors' totals.
    pub(crate) fn of_angles(
        kind: SurveyKind,
        [t_start_us, t_end_us]: [u64; 2],
        known: &Angles,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Self {
        let Angles { angles, sigmas, north_known, horizontal_ut } = known;
        let azimuth = Uncertain { value: angles.azimuth_rad, sigma: sigmas.azimuth_rad };
        let magnetic_azimuth_rad = north_known.then_some(azimuth);
        let norths = magnetic_azimuth_rad.map(|azimuth| Norths::of(azimuth, *horizontal_ut, earth, config));
        let from_scribe_line =
            |angle: f32| positive_angle(libm::remainderf(angle + config.toolface_offset_rad, core::f32::consts::TAU));
        let rotating = kind == SurveyKind::Rotating;
        Self {
            kind,
            t_start_us,
            t_end_us,
            inclination_rad: Uncertain { value: angles.inclination_rad, sigma: sigmas.inclination_rad },
            magnetic_azimuth_rad,
            true_azimuth_rad: norths.as_ref().and_then(|norths| norths.true_azimuth_rad),
            grid_azimuth_rad: norths.as_ref().and_then(|norths| norths.grid_azimuth_rad),
            gravity_toolface_rad: (!rotating).then(|| Uncertain {
                value: from_scribe_line(angles.gravity_toolface_rad),
                sigma: sigmas.gravity_toolface_rad,
            }),
            magnetic_toolface_rad: (*north_known && !rotating).then(|| Uncertain {
                value: from_scribe_line(angles.magnetic_toolface_rad),
                sigma: sigmas.magnetic_toolface_rad,
            }),
            toolface_kind: toolface.update(angles.inclination_rad, config),
            gravity_m_s2: None,
            field_ut: None,
            dip_rad: None,
            temperature_c: None,
            rotating,
        }
    }

    /// Toolface that applies, radians, with the toolface offset.
    #[must_use]
    pub const fn toolface_rad(&self) -> Option<Uncertain> {
        match self.toolface_kind {
            ToolfaceKind::Gravity => self.gravity_toolface_rad,
            ToolfaceKind::Magnetic => self.magnetic_toolface_rad,
        }
    }
}

/// Memory of the toolface that applied, so that noise at the limit does not toggle it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToolfaceSwitch {
    magnetic: bool,
}

impl ToolfaceSwitch {
    pub(crate) const fn new() -> Self {
        Self { magnetic: false }
    }

    pub(crate) fn update(&mut self, inclination_rad: f32, config: &SurveyConfig) -> ToolfaceKind {
        let (limit, hysteresis) = (config.near_vertical_rad, config.near_vertical_hysteresis_rad);
        self.magnetic = near_vertical(self.magnetic, inclination_rad, limit, hysteresis);
        self.kind()
    }

    pub(crate) const fn kind(self) -> ToolfaceKind {
        if self.magnetic { ToolfaceKind::Magnetic } else { ToolfaceKind::Gravity }
    }
}

#[cfg(test)]
mod tests;
