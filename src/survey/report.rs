//! A survey from mean vectors, with all that goes with it.

use super::{
    Quality, Survey, SurveyKind,
    means::BlockMean,
    record::ToolfaceSwitch,
    six_axis::{SixAxis, SixAxisCovariance},
};
use crate::config::{Earth, SurveyConfig};
use nalgebra::Vector3;

/// Mean readings of a survey: the six-axis record. Tool axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SixAxisAverages {
    /// Samples in the means.
    pub samples: u32,
    /// Accelerometer as it reads, m/s^2.
    pub raw_accel_m_s2: [f32; 3],
    /// Magnetometer as it reads, microtesla; `None`: it did not read throughout.
    pub raw_mag_ut: Option<[f32; 3]>,
    /// Calibrated specific force, m/s^2.
    pub force_m_s2: [f32; 3],
    /// Calibrated field, microtesla; `None`: it was not to be believed throughout.
    pub field_ut: Option<[f32; 3]>,
    /// Compensated body rate, rad/s: what is left of the gyro's bias and, where it was not taken out, the earth's rotation.
    pub rate_rad_s: [f32; 3],
}

/// A survey from mean vectors, and what it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurveyReport {
    /// The survey.
    pub survey: Survey,
    /// Its totals against their references.
    pub quality: Quality,
    /// The mean readings. For a rotating survey those across the axis are in the frame that does not turn, and raw means are zero.
    pub averages: SixAxisAverages,
}

impl SurveyReport {
    /// From the means, their covariance and the temperatures. `None`: there is no gravity in them.
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
