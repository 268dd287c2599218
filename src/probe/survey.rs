//! Inputs for a [`Surveyor`](crate::survey::Surveyor).

use super::{Output, Probe};
use crate::{
    compensation::Snapshot,
    sample::{Reading, Sample, SampleFlags, TurnFlags},
    survey::SurveyInput,
};
use nalgebra::Vector3;

/// Vectors of the last sample that [`Output`] does not carry; kept small, because they stand in static RAM.
pub(super) struct Calibrated {
    /// Specific force corrected by the effects that were found, m/s^2.
    pub force_m_s2: [f32; 3],
    /// Field corrected by the effects that were found, microtesla.
    pub field_ut: [f32; 3],
    gyro_usable: bool,
    accel_usable: bool,
    mag_usable: bool,
    accel_clipped: bool,
}

impl Calibrated {
    /// Value before the first sample.
    pub(super) const NONE: Self = Self {
        force_m_s2: [0.0; 3],
        field_ut: [0.0; 3],
        gyro_usable: false,
        accel_usable: false,
        mag_usable: false,
        accel_clipped: false,
    };

    pub(super) fn of(sample: &Sample, [gyro, accel, mag]: [Reading; 3], corrected: &Snapshot) -> Self {
        let usable = |reading| matches!(reading, Reading::Usable(_));
        Self {
            force_m_s2: corrected.force_m_s2.into(),
            field_ut: corrected.field_ut.into(),
            gyro_usable: usable(gyro),
            accel_usable: usable(accel),
            mag_usable: usable(mag),
            accel_clipped: sample.flags.contains(SampleFlags::ACCEL_CLIPPED),
        }
    }
}

impl<const NODES: usize, const COLUMNS: usize, const REPORTS: usize> Probe<NODES, COLUMNS, REPORTS> {
    /// Returns the survey's input of a sample that was just pushed and gave `output`: compensated rate less
    /// the filter's residual bias, calibrated vectors corrected by the found effects, the raw vectors and the
    /// attitude. It is for [`Surveyor::push`](crate::survey::Surveyor::push).
    #[must_use]
    pub fn survey_input(&self, sample: &Sample, output: &Output) -> SurveyInput {
        let input = self.pipeline.survey_input(self.library(), sample, output);
        SurveyInput { mounting_wrong: self.identifier.mounting_wrong(), ..input }
    }
}

/// Survey's input of a sample with the calibrated vectors `kept` and the output `output`; variances on each axis of
/// what was taken out of force and field, (m/s^2)^2 and microtesla^2; residual bias and deviation of the
/// magnetometer's delay, rad/s and seconds.
pub(super) fn input_of(
    kept: &Calibrated,
    (residual_bias_rad_s, mag_delay_sigma_s): (&Vector3<f32>, f32),
    [of_force, of_field]: [Vector3<f32>; 2],
    (sample, output): (&Sample, &Output),
) -> SurveyInput {
    let rate = Vector3::from(output.rate_rad_s) - residual_bias_rad_s;
    let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
    SurveyInput {
        t_us: sample.t_us,
        rate_rad_s: kept.gyro_usable.then(|| rate.into()),
        force_m_s2: kept.accel_usable.then_some(kept.force_m_s2),
        field_ut: kept.mag_usable.then_some(kept.field_ut),
        force_correction_sigma_m_s2: of_force.map(libm::sqrtf).into(),
        field_correction_sigma_ut: of_field.map(libm::sqrtf).into(),
        mag_delay_sigma_s,
        raw_accel_m_s2: sample.accel_m_s2,
        raw_mag_ut: sample.mag_ut,
        mounting_wrong: TurnFlags::empty(),
        accel_clipped: kept.accel_clipped,
        temperature_c: warm.then_some(sample.temperature_c),
        attitude: output.attitude,
    }
}
