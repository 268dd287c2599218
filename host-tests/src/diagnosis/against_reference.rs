//! Diagnosis against a reference attitude, which stands in for the sensors that are not tested.
//!
//! First the gyro is tested: gravity and field are computed from the reference, so what shows is the gyro's
//! error. Then the vectors are tested: the rate is computed from the reference, so what shows is the
//! accelerometer's or the magnetometer's error.

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    compensation::{
        Effect,
        effects::{
            AccelBias, AccelLag, AxialInterference, EddyLag, GSensitivity, GyroBiasTemperature, GyroLag,
            GyroScaleAsymmetry, GyroScaleNonlinearity, HardIron, LeverArm, MagLag, SoftIron, VibrationRectification,
        },
    },
    diagnosis::Verdict,
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::outcome::{Diagnosed, diagnosed_with};
use testbed::{
    failure::Failure,
    flight::{Flight, fly_at_a_desk},
    trace::Trace,
};

/// Effects looked for when the gyro is tested.
static OF_THE_GYRO: [&dyn Effect; 6] = [
    &GyroLag,
    &GyroBiasTemperature,
    &GSensitivity,
    &VibrationRectification,
    &GyroScaleNonlinearity,
    &GyroScaleAsymmetry,
];

/// Effects looked for when the vector sensors are tested.
static OF_THE_VECTORS: [&dyn Effect; 8] =
    [&MagLag, &AccelLag, &EddyLag, &AxialInterference, &HardIron, &SoftIron, &AccelBias, &LeverArm];

/// Magnetic field assumed for the reference where the trace states none, microtesla, 65 deg below the
/// horizontal. Only its direction in the earth counts, and that it does not change.
const FIELD_UT: f64 = 50.0;
const DIP_DEG: f64 = 65.0;

/// Latency of an identification on a desk, seconds.
const AT_ONCE_S: f32 = 0.1;

/// Tests gyro and vectors, each against the reference, and joins the findings: the flight of the gyro, and the
/// configuration that it flew with. `freeze_at_us`: instant from which nothing new takes effect.
///
/// # Errors
/// The trace has no reference or one at too few samples, or the configuration cannot be used.
pub fn against_reference(
    trace: &Trace,
    config: &Config,
    freeze_at_us: Option<u64>,
) -> anyhow::Result<(Flight, Diagnosed, Config)> {
    if trace.reference.iter().flatten().count() < 2 {
        let path = trace.path.display();
        return Err(
            Failure::BadInput(format!("{path}: --against-reference needs the columns qw, qx, qy, qz, filled")).into()
        );
    }
    if !has_dense_reference(trace) {
        return Err(too_few(trace).into());
    }
    let attitudes = attitudes(trace);
    let gyro_trace = Trace { samples: vectors_from(trace, &attitudes), ..trace.clone() };
    let vector_trace = Trace { samples: rates_from(trace, &attitudes), ..trace.clone() };
    let mut config = *config;
    // On a desk results are there at once: data up to the hold-out can be used.
    config.identification.latency_s = AT_ONCE_S;
    let second = fly_at_a_desk(&OF_THE_VECTORS, &config, freeze_at_us, &vector_trace.samples)?;
    let of_vectors = diagnosed_with(&OF_THE_VECTORS, &vector_trace, &config, &second);
    config.identification.vectors_from_reference = true;
    let flight = fly_at_a_desk(&OF_THE_GYRO, &config, freeze_at_us, &gyro_trace.samples)?;
    let of_gyro = diagnosed_with(&OF_THE_GYRO, &gyro_trace, &config, &flight);
    let mut effects = of_gyro.effects;
    effects.extend(of_vectors.effects.iter().cloned());
    let mut reports = of_gyro.reports;
    reports.extend(of_vectors.reports.iter().copied());
    let verdict = joint(of_gyro.verdict, of_vectors.verdict);
    let Diagnosed { magnets, residual, residual_over_time, totals, .. } = of_vectors;
    let diagnosed = Diagnosed { verdict, effects, magnets, reports, residual, residual_over_time, totals };
    Ok((flight, diagnosed, config))
}

/// Returns true if the reference is dense enough to test against, wherever there is one: rates are taken from samples
/// beside each other, so at least half of those with a reference stand beside another.
#[must_use]
pub fn has_dense_reference(trace: &Trace) -> bool {
    let filled = trace.reference.iter().flatten().count();
    let pairs = trace.reference.windows(2).filter(|pair| pair.iter().all(Option::is_some)).count();
    pairs > 0 && 2 * pairs >= filled
}

/// Why a reference at samples apart is refused.
fn too_few(trace: &Trace) -> Failure {
    let (filled, all) = (trace.reference.iter().flatten().count(), trace.len());
    Failure::BadInput(format!(
        "{}: the reference covers only {filled} of {all} samples, hardly two of them in a row: --against-reference takes \
         rates from neighbouring rows, and needs qw, qx, qy, qz at the rate of the samples",
        trace.path.display()
    ))
}

/// The more serious of two verdicts.
fn joint(a: Verdict, b: Verdict) -> Verdict {
    let gravity = |verdict: Verdict| match verdict {
        Verdict::ModelSufficient => 0,
        Verdict::NotEnoughExcitation => 1,
        Verdict::EffectsFound => 2,
        _ => 3,
    };
    if gravity(a) >= gravity(b) { a } else { b }
}

/// Reference attitudes, body to NED.
pub(crate) fn attitudes(trace: &Trace) -> Vec<Option<UnitQuaternion<f64>>> {
    let to_ned = trace.keys.earth_frame.to_ned();
    let one = |q: &Option<[f64; 4]>| {
        let [w, x, y, z] = (*q)?;
        Some(to_ned * UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)))
    };
    trace.reference.iter().map(one).collect()
}

/// Samples with gravity and field computed from the reference.
pub(crate) fn vectors_from(trace: &Trace, attitudes: &[Option<UnitQuaternion<f64>>]) -> Vec<Sample> {
    let keys = &trace.keys;
    let gravity = keys.gravity_m_s2.unwrap_or(9.806_65);
    let dip = keys.dip_deg.unwrap_or(DIP_DEG).to_radians();
    let field = keys.magnetic_field_ut.unwrap_or(FIELD_UT) * Vector3::new(dip.cos(), 0.0, dip.sin());
    let both = trace.samples.iter().zip(attitudes);
    both.map(|(sample, attitude)| {
        let mut sample = *sample;
        let flags = SampleFlags::ACCEL_MISSING | SampleFlags::MAG_MISSING;
        sample.flags.set(flags, attitude.is_none());
        sample.flags.remove(SampleFlags::ACCEL_CLIPPED | SampleFlags::MAG_CLIPPED);
        let body = |v: Vector3<f64>| attitude.map_or_else(Vector3::zeros, |q| q.inverse_transform_vector(&v));
        // Specific force points up at rest.
        sample.accel_m_s2 = body(Vector3::new(0.0, 0.0, -gravity)).cast::<f32>().into();
        sample.mag_ut = body(field).cast::<f32>().into();
        sample
    })
    .collect()
}

/// Samples with the rate computed from the reference, from the sample before to the one after: a central
/// difference has no delay.
fn rates_from(trace: &Trace, attitudes: &[Option<UnitQuaternion<f64>>]) -> Vec<Sample> {
    let rate = |index: usize| -> Option<Vector3<f64>> {
        let (before, after) = (index.checked_sub(1)?, index + 1);
        let (from, to) = ((*attitudes.get(before)?)?, (*attitudes.get(after)?)?);
        let step_us = trace.samples.get(after)?.t_us - trace.samples.get(before)?.t_us;
        Some((from.inverse() * to).scaled_axis() / (step_us as f64 * 1e-6))
    };
    let samples = trace.samples.iter().enumerate();
    samples
        .map(|(index, sample)| {
            let mut sample = *sample;
            let rate = rate(index);
            sample.flags.set(SampleFlags::GYRO_MISSING, rate.is_none());
            sample.flags.remove(SampleFlags::GYRO_CLIPPED);
            sample.gyro_rad_s = rate.unwrap_or_default().cast::<f32>().into();
            sample
        })
        .collect()
}
