//! Calibration of the accelerometer from rests: in any orientation it must read gravity.

use meerkat_mwd::compensation::VectorModel;

use super::{
    model::{Model, Parameters},
    norm_fit::{Observation, Problem},
    rests::Rest,
    sensor::SensorCalibration,
    verdict::Standard,
};

/// Prior of an accelerometer without a calibration, one deviation each: the tolerances of a consumer part
/// (MPU-6050 product specification 3.4, section 6.2: scale 3 %, cross-axis 2 %, zero-g offset 80 mg on the
/// worst axis).
#[must_use]
pub fn prior() -> Parameters {
    let (scale, cross, offset_m_s2) = (0.03, 0.02, 0.08 * 9.806_65);
    Parameters::from_column_slice(&[scale, scale, scale, cross, cross, cross, offset_m_s2, offset_m_s2, offset_m_s2])
}

/// Fits nine parameters to the rests, each with the gravity of its place in m/s^2; `None` without rests.
#[must_use]
pub fn calibrate(rests: &[(Rest, f64)], record: VectorModel) -> Option<SensorCalibration> {
    let observation = |&(rest, gravity_m_s2): &(Rest, f64)| {
        rest.accel.map(|mean| Observation { raw: mean.vector, norm: gravity_m_s2, sigma: mean.sigma })
    };
    let observations: Vec<Observation> = rests.iter().filter_map(observation).collect();
    let norm = observations.first()?.norm;
    let problem =
        Problem { observations: &observations, record: Model::from(record), prior: prior(), correlated: false };
    Some(SensorCalibration::of(&problem, norm, record != VectorModel::IDENTITY, Standard::ToJudgeBy))
}
