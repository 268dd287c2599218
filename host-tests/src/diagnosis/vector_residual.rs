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

use super::totals::{Gathered, Totals};
use testbed::{flight::Flight, trace::Trace};

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

/// One sample compensated in one way.
struct Reading {
    t_s: f64,
    /// Size of the rate, rad/s.
    rate: f64,
    /// Number of gaps before it, in time or of the gyro: nothing is predicted across one.
    gaps: u32,
    /// Specific force and field, turned to the frame of the trace's start.
    vectors: [Option<Vector3<f64>>; 2],
}

/// Residuals of a flight whose effects come from `library`, and what its vector sensors read at the end.
pub(super) fn vector_residual(
    library: &[&dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
) -> (VectorResidual, ResidualOverTime, Totals) {
    let from_s = flight.frozen_at_us.unwrap_or_else(|| trace.first_us()) as f64 * 1e-6;
    let mut at_end = Gathered::until(trace.last_us() as f64 * 1e-6);
    let before = read(library, trace, config, flight, &How::BiasOnly, from_s, |_| {});
    let seen = |reading: &Reading| at_end.push(reading.t_s, reading.gaps, &reading.vectors);
    let after = read(library, trace, config, flight, &How::Flown, from_s, seen);
    let over_time = ResidualOverTime { before, after };
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
    (residual, over_time, at_end.totals())
}

/// Residual of the vector that shows an effect, without it and as flown. A constant that the effect adds to
/// the gyro's reading stays, because without the effect it would be part of the bias.
pub(super) fn residual_without(
    library: &[&dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    found: &EffectReport,
    flown: &ResidualOverTime,
) -> Option<WithoutEffect> {
    let effect = library.get(usize::from(found.found.index));
    let effect = effect.filter(|_| found.is_taken_out() && found.step_us == 0)?;
    let from_s = flight.frozen_at_us.unwrap_or_else(|| trace.first_us()) as f64 * 1e-6;
    let vector = usize::from(effect.sensor() != Sensor::Accelerometer);
    let [gravity, field] = read(library, trace, config, flight, &How::Without(found.found.index), from_s, |_| {});
    let angles = if vector == 0 { gravity } else { field };
    let after = flown.after.get(vector).and_then(|angles| rms_of_kept(angles));
    Some(WithoutEffect { vector, rms: BeforeAfter { before: rms_of_kept(&angles), after }, angles })
}

/// The residual that an effect leaves where it stays in the readings while all others are taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct WithoutEffect {
    /// Index of the vector: 0 for gravity, 1 for the field.
    pub vector: usize,
    /// With the effect in the readings, and as flown, degrees rms.
    pub rms: BeforeAfter,
    /// Seconds and degrees, with the effect in the readings.
    pub angles: Vec<[f64; 2]>,
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

/// Models of a flight and the sample from which each flies, microseconds.
type Stepping = VecDeque<(u64, GyroModel, ActiveEffects)>;

/// Models that flew; those of the windows where no others are known.
fn flown(config: &Config, flight: &Flight) -> Stepping {
    if !flight.models.is_empty() {
        return flight.models.iter().map(|flying| (flying.from_us, flying.gyro, flying.effects())).collect();
    }
    let models = flight.reports.iter().filter_map(|report| Some((report.t_effect_us?, Some(report.flown), None)));
    let conclusive = flight.diagnoses.iter().filter(|report| report.is_conclusive());
    let effects = conclusive.map(|report| (report.t_effect_us, None, Some(report.active())));
    let mut steps: Vec<_> = models.chain(effects).collect();
    steps.sort_by_key(|(t_us, ..)| *t_us);
    let (mut gyro, mut active) = (config.gyro, ActiveEffects::none());
    let step = |(t_us, model, effects): (u64, Option<GyroModel>, Option<ActiveEffects>)| {
        gyro = model.unwrap_or(gyro);
        active = effects.unwrap_or(active);
        (t_us, gyro, active)
    };
    steps.into_iter().map(step).collect()
}

/// The factory's P with each window's bias; before the first window's result with the bias that flies.
fn bias_only(config: &Config, flight: &Flight) -> Stepping {
    let mut windows: Vec<_> = flight.reports.iter().filter_map(|report| Some((report.t_effect_us?, report))).collect();
    windows.sort_by_key(|(t_us, _)| *t_us);
    let first_us = windows.first().map_or(u64::MAX, |(t_us, _)| *t_us);
    let before = flight.models.iter().take_while(|flying| flying.from_us < first_us);
    let before = before.map(|flying| (flying.from_us, GyroModel { b_rad_s: flying.gyro.b_rad_s, ..config.gyro }));
    let after = windows.iter().map(|(t_us, report)| (*t_us, report.bias_only));
    before.chain(after).map(|(t_us, model)| (t_us, model, ActiveEffects::none())).collect()
}

/// Residual angles of gravity and field of a trace compensated in one way, from `from_s` on. `seen` gets every
/// reading.
fn read(
    library: &[&dyn Effect],
    trace: &Trace,
    config: &Config,
    flight: &Flight,
    how: &How,
    from_s: f64,
    mut seen: impl FnMut(&Reading),
) -> [Vec<[f64; 2]>; 2] {
    let corrected = !matches!(how, How::BiasOnly);
    let mean = if let How::Without(index) = how {
        mean_rate_of(library, trace, config, flight, *index)
    } else {
        Vector3::zeros()
    };
    let mut models = if corrected { flown(config, flight) } else { bias_only(config, flight) };
    let (mut model, mut effects): (GyroModel, ActiveEffects) = (config.gyro, ActiveEffects::none());
    let mut segments = Segments { start_s: from_s, readings: VecDeque::new(), angles: [vec![], vec![]] };
    // Differences under a microsecond are rounding.
    let gap_s = (f64::from(GAP_PERIODS) * f64::from(config.sample_period_us) + 0.5) * 1e-6;
    let mut gaps = 0;
    let mut last: Option<(f64, Vector3<f64>, UnitQuaternion<f64>)> = None;
    for sample in trace.samples() {
        let sample = &sample;
        while let Some((_, next, active)) = models.front().filter(|(t_us, ..)| *t_us <= sample.t_us) {
            (model, effects) = (*next, *active);
            models.pop_front();
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
                magnet.is_corrected() && (magnet.from_us..magnet.to_us.unwrap_or(u64::MAX)).contains(&sample.t_us)
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
        let flags = [SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING];
        let [force, field] = [moment.force_m_s2, moment.field_ut];
        let turned = |v: Vector3<f32>, missing| (!sample.flags.contains(missing)).then(|| rotation * v.cast::<f64>());
        let vectors = [turned(force, flags[0]), turned(field, flags[1])];
        let reading = Reading { t_s, rate: rate.norm(), gaps, vectors };
        seen(&reading);
        segments.push(reading);
    }
    segments.angles
}

/// Mean rate that one effect adds to the gyro's reading, rad/s.
fn mean_rate_of(library: &[&dyn Effect], trace: &Trace, config: &Config, flight: &Flight, index: u8) -> Vector3<f32> {
    let last = flight.diagnoses.iter().rev().find(|report| report.is_conclusive());
    let is_of_gyro = library.get(usize::from(index)).is_some_and(|effect| effect.sensor() == Sensor::Gyro);
    let (Some(last), Some(model)) = (last.filter(|_| is_of_gyro), flight.last_model()) else { return Vector3::zeros() };
    let [_, own] = parted(&last.active(), index);
    let from_us = flight.frozen_at_us.unwrap_or_else(|| trace.first_us());
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for sample in trace.samples().filter(|sample| sample.t_us >= from_us) {
        let before = moment(&sample, config, model, None);
        let mut after = before;
        own.correct(library, &mut after);
        sum += before.rate_rad_s - after.rate_rad_s;
        count += 1.0;
    }
    if count > 0.0 { sum / count } else { sum }
}

fn moment(sample: &Sample, config: &Config, model: &GyroModel, last: Option<(f64, Vector3<f64>)>) -> Snapshot {
    let rate = model.compensate(sample.gyro_rad_s);
    let force = config.accel.calibrate(sample.accel_m_s2);
    let warm = !sample.flags.contains(SampleFlags::TEMPERATURE_MISSING);
    Snapshot {
        rate_rad_s: rate,
        acceleration_rad_s2: last.map_or_else(Vector3::zeros, |(dt, before)| (rate - before.cast::<f32>()) / dt as f32),
        force_m_s2: force,
        square_force_m2_s4: force.norm_squared(),
        field_ut: config.mag.calibrate(sample.mag_ut),
        warming_k: if warm { sample.temperature_c - REFERENCE_TEMPERATURE_C } else { 0.0 },
    }
}

/// Residual angles of gravity and field over the moving segments, as the readings come.
struct Segments {
    /// Start of the next segment, seconds.
    start_s: f64,
    /// Readings from there on.
    readings: VecDeque<Reading>,
    /// Middle of the segment in seconds, and degrees.
    angles: [Vec<[f64; 2]>; 2],
}

impl Segments {
    fn push(&mut self, reading: Reading) {
        let t_s = reading.t_s;
        if t_s >= self.start_s {
            self.readings.push_back(reading);
        }
        while self.start_s + SEGMENT_S + MEAN_S <= t_s {
            self.end();
        }
    }

    /// Ends the segment, all of whose readings are there.
    fn end(&mut self) {
        let start_s = self.start_s;
        let at = |t_s: f64| self.readings.partition_point(|reading| reading.t_s < t_s);
        let (first, second) = (0..at(start_s + MEAN_S), at(start_s + SEGMENT_S)..at(start_s + SEGMENT_S + MEAN_S));
        if let Some(next) = self.readings.front().filter(|_| second.end == 0) {
            // Skip the gap at once: it may last for years.
            self.start_s = next.t_s;
            return;
        }
        let all = || self.readings.range(..second.end);
        let square = all().map(|reading| reading.rate * reading.rate).sum::<f64>() / second.end.max(1) as f64;
        let gaps = |reading: Option<&Reading>| reading.map(|reading| reading.gaps);
        if square > MOVING_RAD_S * MOVING_RAD_S && gaps(all().next()) == gaps(all().next_back()) {
            for (vector, angles) in self.angles.iter_mut().enumerate() {
                let mean = |range: &std::ops::Range<usize>| -> Option<Vector3<f64>> {
                    let there = self.readings.range(range.clone());
                    let read: Vec<_> = there.filter_map(|reading| *reading.vectors.get(vector)?).collect();
                    (!read.is_empty()).then(|| read.iter().copied().sum::<Vector3<f64>>() / read.len() as f64)
                };
                if let (Some(a), Some(b)) = (mean(&first), mean(&second)) {
                    angles.push([start_s + 0.5 * (SEGMENT_S + MEAN_S), a.angle(&b).to_degrees()]);
                }
            }
        }
        self.start_s += SEGMENT_S;
        while self.readings.front().is_some_and(|reading| reading.t_s < self.start_s) {
            self.readings.pop_front();
        }
    }
}

/// Root mean square of the residuals that count, degrees.
fn rms_of_kept(angles: &[[f64; 2]]) -> Option<f64> {
    let mut angles: Vec<f64> = angles.iter().map(|[_, angle]| *angle).collect();
    angles.sort_by(f64::total_cmp);
    let kept = (angles.len() as f64 * KEPT) as usize;
    let sum: f64 = angles.iter().take(kept).map(|a| a * a).sum();
    (kept > 0).then(|| (sum / kept as f64).sqrt())
}
