//! Calibration: accelerometer and magnetometer models from rests and turns, as a factory record with its
//! account.

mod accelerometer;
mod account;
mod alignment;
mod held_out;
mod magnetometer;
mod model;
mod norm_fit;
pub mod record;
pub mod result;
mod rests;
pub mod sensor;
pub mod verdict;

use std::path::Path;

use meerkat_mwd::{Config, Sample, SampleFlags, compensation::VectorModel, config::VectorErrors};

pub use account::print_account;
pub use alignment::Alignment;
pub use held_out::HeldOut;
pub use model::{Model, NAMES};
pub use rests::{Mean, Rest, rests};
pub use sensor::SensorCalibration;
pub use verdict::Verdict;

use held_out::norm_error;
use norm_fit::Observation;
use testbed::{
    failure::Failure,
    flight::configuration::{freeze_at_us, of_file},
    score::root_mean_square,
    trace::Trace,
};

/// The factory record before the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Record {
    /// The accelerometer's model.
    pub accel: VectorModel,
    /// The magnetometer's model.
    pub mag: VectorModel,
    /// Errors that those calibrations left.
    pub left: VectorErrors,
}

/// Findings of a calibration.
#[derive(Clone, Debug, Default)]
pub struct Calibration {
    /// Names of the traces.
    pub traces: Vec<String>,
    /// Day of each, where its header states one.
    pub dates: Vec<Option<chrono::NaiveDate>>,
    /// Remarks for the user.
    pub notes: Vec<String>,
    /// The record before.
    pub record: Record,
    /// All rests.
    pub rests: Vec<Rest>,
    /// The accelerometer's calibration; `None` if no rest has its readings.
    pub accel: Option<SensorCalibration>,
    /// Check of its norm on rests of the held-out part.
    pub later: Option<HeldOut>,
    /// The magnetometer's calibration; `None` without readings.
    pub mag: Option<SensorCalibration>,
    /// Check of its norm on turns of the held-out part.
    pub mag_later: Option<HeldOut>,
    /// Alignment of the magnetometer's axes; `None` unless both sensors have a calibration, old or new.
    pub alignment: Option<Alignment>,
}

/// Calibrates the sensors of one probe on all its traces together, starting from the record in `config`. The
/// last `hold_out` of each trace is only used to check.
///
/// # Errors
/// A configuration that cannot be used.
pub fn calibrate(traces: &[Trace], config: Option<&Path>, hold_out: Option<f64>) -> Result<Calibration, Failure> {
    let mut found = Calibration::default();
    let (mut rests_and_gravity, mut later) = (Vec::new(), Vec::new());
    let (mut turns, mut later_turns, mut unstated) = (Vec::new(), Vec::new(), 0);
    for trace in traces {
        let config = of_file(trace, config)?;
        let mut samples = trace.clone();
        samples.mark_clipped(&config.full_scale);
        let freeze_us = hold_out.map_or(u64::MAX, |fraction| freeze_at_us(trace, fraction));
        let split = samples.samples.partition_point(|sample| sample.t_us < freeze_us);
        let (first, last) = samples.samples.split_at(split);
        let gravity_m_s2 = f64::from(config.earth.gravity_m_s2);
        let with_gravity = |rest| (rest, gravity_m_s2);
        rests_and_gravity.extend(rests(first, &config).into_iter().map(with_gravity));
        later.extend(rests(last, &config).into_iter().map(with_gravity));
        let field_ut = config.earth.magnetic_field_ut.map(f64::from);
        let with_field = |raw| (raw, field_ut);
        turns.extend(magnetometer::turn(first).into_iter().map(with_field));
        later_turns.extend(magnetometer::turn(last).into_iter().map(with_field));
        unstated += usize::from(field_ut.is_none());
        found.record = Record { accel: config.accel, mag: config.mag, left: config.identification.vector_errors };
        found.traces.push(trace.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()));
        found.dates.push(trace.keys.date);
        found.notes.extend(trace.notes.iter().cloned());
        found.notes.extend(clipping_note(&samples.samples, &config));
    }
    found.rests = rests_and_gravity.iter().map(|(rest, _)| *rest).collect();
    found.accel = accelerometer::calibrate(&rests_and_gravity, found.record.accel);
    if let Some(accel) = &mut found.accel {
        let observation = |(rest, norm): &(Rest, f64)| {
            rest.accel.map(|mean| Observation { raw: mean.vector, norm: *norm, sigma: mean.sigma })
        };
        found.later = checked_later(accel, &later.iter().filter_map(observation).collect::<Vec<_>>());
        accel.judge_on(found.later.as_ref());
    }
    found.mag = magnetometer::calibrate(&turns, found.record.mag);
    if let Some(mag) = &mut found.mag {
        let observations = magnetometer::observations(&later_turns, mag.norm_known, mag.norm);
        found.mag_later = checked_later(mag, &observations.collect::<Vec<_>>());
        mag.judge_on(found.mag_later.as_ref());
        if unstated > 0 && traces.len() > 1 && !magnetometer::fields_differ(&turns) {
            found.notes.push(format!(
                "{unstated} of {} traces state no field (magnetic_field_ut): for the magnetometer they are taken to be of one place",
                traces.len()
            ));
        }
    }
    found.alignment = found.aligned();
    Ok(found)
}

impl Calibration {
    fn aligned(&self) -> Option<Alignment> {
        let on_record = |sensor: Option<&SensorCalibration>, old: VectorModel| {
            sensor.is_some_and(SensorCalibration::is_new) || old != VectorModel::IDENTITY
        };
        let both = on_record(self.accel.as_ref(), self.record.accel) && on_record(self.mag.as_ref(), self.record.mag);
        let accel = self.accel.as_ref()?.model();
        both.then(|| alignment::align(&self.rests, &accel, &self.mag.as_ref()?.model())).flatten()
    }

    /// The accelerometer's model that goes on record.
    #[must_use]
    pub fn accel_model(&self) -> VectorModel {
        let new = self.accel.as_ref().filter(|sensor| sensor.is_new());
        new.map_or(self.record.accel, |sensor| sensor.model().into())
    }

    /// The magnetometer's model that goes on record.
    #[must_use]
    pub fn mag_model(&self) -> VectorModel {
        let old = self.record.mag;
        let Some(mag) = &self.mag else { return old };
        let turned = self.alignment.as_ref().filter(|alignment| alignment.refused.is_none());
        match (mag.is_new(), turned) {
            (false, None) => old,
            (_, None) => mag.model().into(),
            (_, Some(alignment)) => alignment.applied(&mag.model()).into(),
        }
    }

    /// Reason why the accelerometer cannot be calibrated at all.
    #[must_use]
    pub fn no_accel(&self) -> String {
        if self.rests.is_empty() {
            return "no rest was found (a second in which neither gyro nor vectors move)".into();
        }
        let clipped = self.rests.iter().filter(|rest| rest.clipped).count();
        format!("none of {} rests has usable readings of it ({clipped} with a sensor at full scale)", self.rests.len())
    }

    /// Reason why the magnetometer cannot be calibrated at all.
    #[must_use]
    pub fn no_mag(&self) -> String {
        "there are no readings of a magnetometer".into()
    }
}

/// Errors of the norm at observations later than those fitted: about their own mean where no norm is known.
fn checked_later(sensor: &SensorCalibration, later: &[Observation]) -> Option<HeldOut> {
    let errors = |model: Model| later.iter().map(move |observation| norm_error(&model, observation));
    let rms = |model: Model| match sensor.norm_known {
        true => root_mean_square(errors(model)),
        false => (!later.is_empty()).then(|| magnetometer::scatter(&model, later)),
    };
    Some(HeldOut {
        how: "fitted to the part before",
        count: later.len(),
        before: rms(sensor.record)?,
        after: rms(sensor.fit.model)?,
        noise: root_mean_square(later.iter().map(|observation| observation.sigma))?,
        largest: errors(sensor.fit.model).fold(0.0, |largest: f64, error| largest.max(error.abs())),
    })
}

/// A note on readings at full scale, or that clipping cannot be known.
fn clipping_note(samples: &[Sample], config: &Config) -> Option<String> {
    let count = |flag| samples.iter().filter(|sample| sample.flags.contains(flag)).count();
    let (accel, mag) = (count(SampleFlags::ACCEL_CLIPPED), count(SampleFlags::MAG_CLIPPED));
    let scales = &config.full_scale;
    if scales.accel_m_s2.is_none() && scales.mag_ut.is_none() {
        Some("no full scale of the vector sensors is known: clipped readings cannot be told".into())
    } else {
        (accel + mag > 0)
            .then(|| format!("at full scale and left out: {accel} of the accelerometer, {mag} of the magnetometer"))
    }
}
