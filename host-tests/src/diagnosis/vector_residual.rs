//! Residual of gravity and field over one second: predicted by the gyro from a second before, minus measured.

use std::collections::VecDeque;

use meerkat_mwd::{
    Config, Sample, SampleFlags,
    compensation::{ActiveEffects, Effect, GyroModel, Sensor, Snapshot, effect::REFERENCE_TEMPERATURE_C},
    diagnosis::EffectReport,
    magnet::HardIronInterval,
    probe::GAP_PERIODS,
};
use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;

use crate::{flight::Flight, trace::Trace};

/// Time over which a vector is predicted, seconds.
const SEGMENT_S: f64 = 1.0;

/// Length of the mean that stands for a vector, seconds; its readings are turned to its middle.
const MEAN_S: f64 = 0.1;

/// Least rate of a segment, rad/s rms (3 deg/s): a slower one tells nothing about rotation.
const MOVING_RAD_S: f64 = 0.052;

/// Share of the residuals that count, the smallest, as in the scores.
const KEPT: f64 = 0.98;

/// A figure before and after.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BeforeAfter {
    /// With the factory's P, the bias alone and no effect.
    pub before: Option<f64>,
    /// As flown, with every accepted parameter and effect.
    pub after: Option<f64>,
}

/// Residuals of the vectors; over the held-out part if the flight was frozen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct VectorResidual {
    /// Angle of gravity's residual, degrees rms.
    pub gravity_deg: BeforeAfter,
    /// Angle of the field's, degrees rms.
    pub magnetic_deg: BeforeAfter,
    /// Mean square of the last diagnosis's innovations, in units of their variance.
    pub nis: BeforeAfter,
}

/// Residual angles over time (seconds, degrees), of gravity and of the field.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResidualOverTime {
    /// With the factory's P, the bias alone and no effect.
    pub before: [Vec<[f64; 2]>; 2],
    /// As flown, with every accepted parameter and effect.
    pub after: [Vec<[f64; 2]>; 2],
}

/// A trace compensated in one way.
struct Reading {
    t_s: Vec<f64>,
    rotation: Vec<UnitQuaternion<f64>>,
    rate: Vec<f64>,
    /// Number of gaps before each sample, in time or of the gyro: nothing is predicted across one.
    gaps: Vec<u32>,
    /// Specific force and field, turned to the frame of the trace's start.
    vectors: [Vec<Option<Vector3<f64>>>; 2],
}

/// Residuals of a flight whose effects come from `library`.
pub(super) fn vector_residual(
    library: &[&dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
) -> (VectorResidual, ResidualOverTime) {
    let from_s = config.freeze_at_us.unwrap_or_else(|| trace.first_us()) as f64 * 1e-6;
    let angles = |how: &How| residuals(&read(library, trace, config, flight, how), from_s);
    let over_time = ResidualOverTime { before: angles(&How::BiasOnly), after: angles(&How::Flown) };
    let figures = |angles: &[Vec<[f64; 2]>; 2]| angles.each_ref().map(|angles| rms_of_kept(angles));
    let ([gravity_before, field_before], [gravity_after, field_after]) =
        (figures(&over_time.before), figures(&over_time.after));
    let last = flight.diagnoses.iter().rev().find(|report| report.is_conclusive());
    let residual = VectorResidual {
        gravity_deg: BeforeAfter { before: gravity_before, after: gravity_after },
        magnetic_deg: BeforeAfter { before: field_before, after: field_after },
        nis: BeforeAfter {
            before: last.map(|report| f64::from(report.nis[0])),
            after: last.map(|report| f64::from(report.nis[1])),
        },
    };
    (residual, over_time)
}

/// Residual of the vector that shows an effect, without it and as flown. A constant that the effect adds to
/// the gyro's reading stays, because without the effect it would be part of the bias.
pub(super) fn residual_without(
    library: &[&dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    found: &EffectReport,
) -> BeforeAfter {
    let effect = library.get(usize::from(found.found.index));
    let Some(effect) = effect.filter(|_| found.is_taken_out() && found.step_us == 0) else {
        return BeforeAfter::default();
    };
    let from_s = config.freeze_at_us.unwrap_or_else(|| trace.first_us()) as f64 * 1e-6;
    let vector = usize::from(effect.sensor() != Sensor::Accelerometer);
    let residual = |how: &How| {
        residuals(&read(library, trace, config, flight, how), from_s).get(vector).and_then(|angles| rms_of_kept(angles))
    };
    BeforeAfter { before: residual(&How::Without(found.found.index)), after: residual(&How::Flown) }
}

/// Ways to compensate a trace.
enum How {
    /// With the factory's P and the bias alone.
    BiasOnly,
    /// As it flew.
    Flown,
    /// As flown, without one effect of the library.
    Without(u8),
}

/// Splits the active effects into all others and that one.
fn parted(effects: &ActiveEffects, without: u8) -> [ActiveEffects; 2] {
    let mut parts = [ActiveEffects::none(); 2];
    for found in effects.iter() {
        parts[usize::from(found.index == without)].add(*found);
    }
    parts
}

/// Compensates a trace.
fn read(library: &[&dyn Effect], trace: &Trace, config: &Config, flight: &Flight, how: &How) -> Reading {
    let corrected = !matches!(how, How::BiasOnly);
    let mean = if let How::Without(index) = how {
        mean_rate_of(library, trace, config, flight, *index)
    } else {
        Vector3::zeros()
    };
    let mut models: VecDeque<_> = flight.reports.iter().filter_map(|r| Some((r.t_effect_us?, r))).collect();
    models.make_contiguous().sort_by_key(|&(t_us, _)| t_us);
    let mut diagnoses: VecDeque<_> = flight.diagnoses.iter().filter(|r| r.is_conclusive()).collect();
    let (mut model, mut effects): (GyroModel, ActiveEffects) = (config.gyro, ActiveEffects::none());
    let mut reading = Reading { t_s: vec![], rotation: vec![], rate: vec![], gaps: vec![], vectors: [vec![], vec![]] };
    // Differences under a microsecond are rounding.
    let gap_s = (f64::from(GAP_PERIODS) * f64::from(config.sample_period_us) + 0.5) * 1e-6;
    let mut gaps = 0;
    let mut last: Option<(f64, Vector3<f64>, UnitQuaternion<f64>)> = None;
    for sample in &trace.samples {
        while let Some((_, report)) = models.front().filter(|(t_us, _)| *t_us <= sample.t_us) {
            model = if corrected { report.flown } else { report.bias_only };
            models.pop_front();
        }
        while let Some(report) = diagnoses.front().filter(|report| report.t_effect_us <= sample.t_us) {
            effects = report.active();
            diagnoses.pop_front();
        }
        let t_s = sample.t_us as f64 * 1e-6;
        let missing = sample.flags.contains(SampleFlags::GYRO_MISSING);
        if missing || last.is_some_and(|(before_s, ..)| t_s - before_s > gap_s) {
            gaps += u32::from(last.take().is_some());
        }
        if missing {
            continue;
        }
        let mut moment = moment(sample, config, &model, last.map(|(t, w, _)| (t_s - t, w)));
        if corrected {
            let there = |magnet: &&HardIronInterval| {
                magnet.corrected && (magnet.from_us..magnet.to_us.unwrap_or(u64::MAX)).contains(&sample.t_us)
            };
            flight.magnets.iter().filter(there).for_each(|magnet| moment.field_ut -= magnet.offset());
            match how {
                How::Without(index) => {
                    let [others, _] = parted(&effects, *index);
                    others.correct(library, &mut moment);
                    moment.rate_rad_s -= mean;
                }
                _ => effects.correct(library, &mut moment),
            }
        }
        let rate: Vector3<f64> = moment.rate_rad_s.cast();
        let rotation = last.map_or_else(UnitQuaternion::identity, |(before_s, before, q)| {
            q * UnitQuaternion::from_scaled_axis((before + rate) * (0.5 * (t_s - before_s)))
        });
        last = Some((t_s, rate, rotation));
        reading.t_s.push(t_s);
        reading.rotation.push(rotation);
        reading.rate.push(rate.norm());
        reading.gaps.push(gaps);
        let flags = [SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        for ((vectors, v), missing) in reading.vectors.iter_mut().zip([moment.force_m_s2, moment.field_ut]).zip(flags) {
            vectors.push((!sample.flags.contains(missing)).then(|| rotation * v.cast::<f64>()));
        }
    }
    reading
}

/// Mean rate that one effect adds to the gyro's reading, rad/s.
fn mean_rate_of(library: &[&dyn Effect], trace: &Trace, config: &Config, flight: &Flight, index: u8) -> Vector3<f32> {
    let last = flight.diagnoses.iter().rev().find(|report| report.is_conclusive());
    let (Some(last), Some(window)) = (last, flight.reports.last()) else { return Vector3::zeros() };
    let [_, own] = parted(&last.active(), index);
    let from_us = config.freeze_at_us.unwrap_or_else(|| trace.first_us());
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for sample in trace.samples.iter().filter(|sample| sample.t_us >= from_us) {
        let before = moment(sample, config, &window.flown, None);
        let mut after = before;
        own.correct(library, &mut after);
        sum += before.rate_rad_s - after.rate_rad_s;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { sum }
}

fn moment(sample: &Sample, config: &Config, model: &GyroModel, last: Option<(f64, Vector3<f64>)>) -> Snapshot {
    let rate = model.compensate(sample.gyro_rad_s);
    let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
    Snapshot {
        rate_rad_s: rate,
        acceleration_rad_s2: last.map_or_else(Vector3::zeros, |(dt, before)| (rate - before.cast::<f32>()) / dt as f32),
        force_m_s2: config.accel.calibrate(sample.accel_m_s2),
        square_force_m2_s4: config.accel.calibrate(sample.accel_m_s2).norm_squared(),
        field_ut: config.mag.calibrate(sample.mag_ut),
        warming_k: if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { 0.0 },
    }
}

/// Residual angles of gravity and field over the moving segments from `from_s` on: middle of the segment in
/// seconds, and degrees.
fn residuals(reading: &Reading, from_s: f64) -> [Vec<[f64; 2]>; 2] {
    let at = |t_s: f64| reading.t_s.partition_point(|&t| t < t_s);
    let mut angles: [Vec<[f64; 2]>; 2] = [vec![], vec![]];
    let (mut start_s, end_s) = (from_s, reading.t_s.last().copied().unwrap_or(0.0));
    while start_s + SEGMENT_S + MEAN_S <= end_s {
        let (first, second) =
            (at(start_s)..at(start_s + MEAN_S), at(start_s + SEGMENT_S)..at(start_s + SEGMENT_S + MEAN_S));
        if let Some(&next_s) = reading.t_s.get(first.start).filter(|_| first.start == second.end) {
            // Skip the gap at once: it may last for years.
            start_s = next_s;
            continue;
        }
        let rates = reading.rate.get(first.start..second.end).unwrap_or_default();
        let square = rates.iter().map(|w| w * w).sum::<f64>() / rates.len().max(1) as f64;
        let gaps = reading.gaps.get(first.start..second.end).unwrap_or_default();
        if square > MOVING_RAD_S * MOVING_RAD_S && gaps.first() == gaps.last() {
            for (angles, vectors) in angles.iter_mut().zip(&reading.vectors) {
                let mean = |range: &std::ops::Range<usize>| -> Option<Vector3<f64>> {
                    let all = vectors.get(range.clone()).unwrap_or_default();
                    let read: Vec<_> = all.iter().flatten().collect();
                    (!read.is_empty()).then(|| read.iter().copied().sum::<Vector3<f64>>() / read.len() as f64)
                };
                if let (Some(a), Some(b)) = (mean(&first), mean(&second)) {
                    angles.push([start_s + 0.5 * (SEGMENT_S + MEAN_S), a.angle(&b).to_degrees()]);
                }
            }
        }
        start_s += SEGMENT_S;
    }
    angles
}

/// Root mean square of the residuals that count, degrees.
fn rms_of_kept(angles: &[[f64; 2]]) -> Option<f64> {
    let mut angles: Vec<f64> = angles.iter().map(|[_, angle]| *angle).collect();
    angles.sort_by(f64::total_cmp);
    let kept = (angles.len() as f64 * KEPT) as usize;
    let sum: f64 = angles.iter().take(kept).map(|a| a * a).sum();
    (kept > 0).then(|| (sum / kept as f64).sqrt())
}
