//! Bounds of the attitude on recordings: estimates that are told more than a probe can know, and each of the two
//! filters without the other.

use std::collections::HashMap;

use meerkat_mwd::{
    Sample, SampleFlags,
    attitude::{AttitudeFilter, AttitudeFlags},
    compensation::effects::LIBRARY,
    estimator::{Estimator, KnownAttitude, Settings as EstimatorSettings},
    sample::Reading,
};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3};

use super::AKTOS_T;
use testbed::{
    flight::{configuration::of_trace, started},
    score::{Settings, TimedAttitude, reference_attitudes},
    trace::Trace,
};

/// The reference itself, told as late as the gyro of the recordings is.
pub(super) fn late(trace: &Trace) -> Vec<TimedAttitude> {
    let late_us = (AKTOS_T.gyro_s.unwrap_or(0.0) * 1e6) as u64;
    let told = |(t_us, q): (u64, UnitQuaternion<f64>)| (t_us + late_us, [q.w, q.i, q.j, q.k]);
    reference_attitudes(trace, &Settings::default()).into_iter().map(told).collect()
}

/// The reference itself, turned about the vertical to the north that the magnetometer's mean over the recording shows:
/// its errors that are fixed in the probe average out where the probe turns, and a field that is off all along does
/// not.
pub(super) fn to_the_fields_north(trace: &Trace) -> Vec<TimedAttitude> {
    let fields = trace.samples.iter().filter(|sample| !sample.flags.contains(SampleFlags::MAG_MISSING));
    let fields: HashMap<u64, [f32; 3]> = fields.map(|sample| (sample.t_us, sample.mag_ut)).collect();
    let known = reference_attitudes(trace, &Settings::default());
    let of = |(t_us, q): &(u64, UnitQuaternion<f64>)| Some(q * Vector3::from(*fields.get(t_us)?).map(f64::from));
    let mean = known.iter().filter_map(of).map(|field| field.xy().normalize()).sum::<Vector2<f64>>();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, -mean.y.atan2(mean.x)));
    let turned = |(t_us, q): (u64, UnitQuaternion<f64>)| {
        let q = turn * q;
        (t_us, [q.w, q.i, q.j, q.k])
    };
    known.into_iter().map(turned).collect()
}

/// The attitudes of a cold flight up to the instant at which its P first changes, then those of a warm one: the first
/// update could not tell more.
///
/// # Errors
/// The trace has no configuration that can be flown.
pub(super) fn warm_from_the_first_update(
    trace: &Trace,
    cold: &[TimedAttitude],
    warm: &[TimedAttitude],
) -> anyhow::Result<Vec<TimedAttitude>> {
    let mut probe = started(&of_trace(trace), None, None)?;
    let first = probe.gyro_model().p;
    let updated = trace.samples.iter().find(|sample| {
        probe.push(sample);
        probe.poll(probe.poll_budget());
        probe.gyro_model().p != first
    });
    let updated_us = updated.map_or(u64::MAX, |sample| sample.t_us);
    let before = cold.iter().take_while(|(t_us, _)| *t_us < updated_us);
    Ok(before.chain(warm.iter().skip_while(|(t_us, _)| *t_us < updated_us)).copied().collect())
}

/// The attitude filter without an estimator.
pub(super) fn filter_alone(trace: &Trace) -> Vec<TimedAttitude> {
    let config = of_trace(trace);
    let mut filter = AttitudeFilter::new();
    filter.start(&config.attitude, &config.earth, config.identification.motion);
    let mut before_us = None;
    let mut attitudes = Vec::with_capacity(trace.samples.len());
    for sample in &trace.samples {
        let step_s = (sample.t_us - before_us.replace(sample.t_us).unwrap_or(sample.t_us)) as f32 * 1e-6;
        filter.propagate(step_s, &Vector3::from(sample.gyro_rad_s));
        let of = |missing: SampleFlags, v: [f32; 3]| (!sample.flags.contains(missing)).then(|| Vector3::from(v));
        filter.observe(
            of(SampleFlags::ACCEL_MISSING, sample.accel_m_s2).as_ref(),
            of(SampleFlags::MAG_MISSING, sample.mag_ut).as_ref(),
        );
        let attitude = filter.attitude(AttitudeFlags::empty());
        attitudes.extend(attitude.map(|attitude| (sample.t_us, attitude.q.map(f64::from))));
    }
    attitudes
}

/// The estimator's own attitude without an attitude filter, wherever it can be asked for it, some 25 times a second.
pub(super) fn estimators_own(trace: &Trace) -> Vec<TimedAttitude> {
    let config = of_trace(trace);
    let mut estimator = Box::new(Estimator::<f32>::zero());
    estimator.configure(&EstimatorSettings::new(&config), &LIBRARY);
    let north_rad = f64::from(config.earth.declination_rad.unwrap_or(0.0));
    let north = Rotation3::from_scaled_axis(Vector3::new(0.0, 0.0, north_rad));
    let update_us = (1e6 * config.identification.update_s) as u64;
    let mut next_us = None;
    let mut attitudes = Vec::new();
    for sample in &trace.samples {
        let can_look = estimator.push(sample.t_us, readings(sample), None);
        if can_look {
            estimator.look();
        }
        if sample.t_us >= *next_us.get_or_insert(sample.t_us + update_us) {
            estimator.close(false);
            next_us = Some(sample.t_us + update_us);
        }
        while estimator.step() > 0 {}
        if let Some(KnownAttitude { rotation, .. }) = estimator.known_attitude().filter(|_| can_look) {
            let rotation: Matrix3<f64> = north.matrix() * rotation.cast::<f64>();
            let q = UnitQuaternion::from_matrix(&rotation);
            attitudes.push((sample.t_us, [q.w, q.i, q.j, q.k]));
        }
    }
    attitudes
}

fn readings(sample: &Sample) -> [Reading; 3] {
    let of = |missing: SampleFlags, v: [f32; 3]| {
        if sample.flags.intersects(missing) { Reading::Missing } else { Reading::Usable(Vector3::from(v)) }
    };
    [
        of(SampleFlags::GYRO_MISSING | SampleFlags::GYRO_CLIPPED, sample.gyro_rad_s),
        of(SampleFlags::ACCEL_MISSING, sample.accel_m_s2),
        of(SampleFlags::MAG_MISSING, sample.mag_ut),
    ]
}
