//! Report of a survey from mean vectors.

use super::{
    Quality, Survey, SurveyKind,
    means::BlockMean,
    record::ToolfaceSwitch,
    six_axis::{SixAxis, SixAxisCovariance},
};
use crate::config::{Earth, SurveyConfig};
use nalgebra::Vector3;

/// Six-axis record: the mean readings of a survey, tool axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SixAxisAverages {
    /// Number of samples in the means.
    pub samples: u32,
    /// Raw accelerometer, m/s^2.
    pub raw_accel_m_s2: [f32; 3],
    /// Raw magnetometer, microtesla; `None` if readings were missing for long.
    pub raw_mag_ut: Option<[f32; 3]>,
    /// Calibrated specific force, m/s^2.
    pub force_m_s2: [f32; 3],
    /// Calibrated field, microtesla; `None` if it was not usable for long.
    pub field_ut: Option<[f32; 3]>,
    /// Compensated body rate, rad/s: residual bias of the gyro and, unless taken out, the earth's rotation.
    pub rate_rad_s: [f32; 3],
}

/// Survey from mean vectors, with its quality.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurveyReport {
    /// The survey.
    pub survey: Survey,
    /// Quality: |G|, |B| and dip against their references, and the mounting.
    pub quality: Quality,
    /// Mean readings. For a rotating survey the components across the axis are in the frame that does not turn, and
    /// there are no raw means (zero for the accelerometer).
    pub averages: SixAxisAverages,
}

impl SurveyReport {
    /// Creates a report of the means, their covariance and the temperatures; `None` if they hold no gravity.
    pub(crate) fn of(
        kind: SurveyKind,
        span_us: [u64; 2],
        averages: SixAxisAverages,
        covariance: &SixAxisCovariance,
        warmth: &BlockMean,
        toolface: &mut ToolfaceSwitch,
        (earth, config): (&Earth, &SurveyConfig),
    ) -> Option<Self> {
        let field = averages.field_ut.map(Vector3::from);
        let six = SixAxis::of(&-Vector3::from(averages.force_m_s2), field.as_ref())?;
        let mut survey = Survey::of_six_axis(kind, span_us, &six, covariance, toolface, (earth, config));
        survey.temperature_c = warmth.mean().map(|warmth| warmth.x);
        Some(Self { survey, quality: Quality::of(&survey, earth, config), averages })
    }
}
