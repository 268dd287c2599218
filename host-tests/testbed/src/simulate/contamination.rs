//! Contamination of a window as on a real rig, laid over a simulated trace in bursts: one kind at a time, on
//! a stated share of the samples.

use std::{f64::consts::TAU, ops::Range};

use meerkat_mwd::Sample;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::{random::Random, vibration::STANDARD_GRAVITY_M_S2};
use crate::trace::Trace;

/// Kind of contamination during a burst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contamination {
    /// Casing joints and other steel in the earth: a field fixed in the earth of 5 to 40 microtesla on top,
    /// and up to 30 % more or less of the earth's own.
    CasingJoints,
    /// A current in the tool: 5 to 40 microtesla along one axis of the body, the same axis in every burst.
    MagneticBursts,
    /// Magnetised steel of the string: an offset that is a linear map of the field, so that it turns with the
    /// attitude.
    AttitudeDependent,
    /// Trains of one-sided shocks on the accelerometer: 2 to 10 g that die out within 20 to 60 ms, 5 to 25 of
    /// them a second, and 50 mg of rectified vibration.
    ShockTrains,
    /// The gyro's full scale is so low that the stated share of the samples, the fastest ones, is clipped
    /// without a flag.
    GyroClipping,
    /// The accelerometer or the magnetometer saturates at 30 to 70 % of what it should read.
    VectorClipping,
    /// Rectified vibration: an offset of the gyro of 2 to 20 deg/s while the burst lasts, in half of the
    /// bursts with spikes of 50 to 500 deg/s on every fifth sample.
    GyroBursts,
}

impl Contamination {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::CasingJoints,
        Self::MagneticBursts,
        Self::AttitudeDependent,
        Self::ShockTrains,
        Self::GyroClipping,
        Self::VectorClipping,
        Self::GyroBursts,
    ];
}

/// Which sensors are hit, sample by sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Hits {
    /// Samples with the gyro hit.
    pub gyro: Vec<bool>,
    /// Samples with the accelerometer hit.
    pub accel: Vec<bool>,
    /// Samples with the magnetometer hit.
    pub mag: Vec<bool>,
}

impl Hits {
    /// Share of a window's samples with any sensor hit.
    #[must_use]
    pub fn share(&self, window: &Range<usize>) -> f64 {
        let any = |k: usize| [&self.gyro, &self.accel, &self.mag].iter().any(|hit| hit.get(k) == Some(&true));
        window.clone().filter(|&k| any(k)).count() as f64 / window.len() as f64
    }
}

/// Shortest and longest burst, seconds.
const BURST_S: [f64; 2] = [0.1, 5.0];

/// A copy of the trace with `share` of the samples of `window` hit, and which ones. Needs the true attitude;
/// all other samples stay the same to the bit. Bursts have uniform lengths of 0.1 to 5 s and lie at random
/// (those of a clipped gyro follow the motion).
#[must_use]
pub fn contaminate(trace: &Trace, kind: Contamination, share: f64, window: &Range<usize>, seed: u64) -> (Trace, Hits) {
    let mut random = Random::new(seed ^ 0xC0_47A0);
    let mut hit = trace.clone();
    let none = || vec![false; trace.samples.len()];
    let mut hits = Hits { gyro: none(), accel: none(), mag: none() };
    let accelerometer = random.uniform() < 0.5;
    if kind == Contamination::GyroClipping {
        clip_gyro(&mut hit.samples, share, window, &mut hits.gyro);
        return (hit, hits);
    }
    let period_s = f64::from(trace.nominal_period_us()) * 1e-6;
    let source = Source { axis: random.direction().into(), steel: Matrix3::from_fn(|_, _| 0.15 * random.normal()) };
    for burst in bursts(window, share, period_s, &mut random) {
        let samples = hit.samples.get_mut(burst.clone()).unwrap_or_default();
        let mask = match kind {
            Contamination::CasingJoints => {
                let attitudes = trace.reference.get(burst.clone()).unwrap_or_default();
                casing_joint(samples, attitudes, &mut random);
                &mut hits.mag
            }
            Contamination::MagneticBursts => {
                let offset_ut = source.axis * random.between(5.0, 40.0);
                add_in_and_out(samples.iter_mut().map(|s| &mut s.mag_ut), |_| offset_ut);
                &mut hits.mag
            }
            Contamination::AttitudeDependent => {
                let steel = source.steel * random.between(0.5, 1.5);
                add_in_and_out(samples.iter_mut().map(|s| &mut s.mag_ut), |field_ut| steel * field_ut);
                &mut hits.mag
            }
            Contamination::ShockTrains => {
                shock_train(samples, period_s, &mut random);
                &mut hits.accel
            }
            Contamination::VectorClipping if accelerometer => {
                saturate(samples.iter_mut().map(|s| &mut s.accel_m_s2).collect(), &mut random);
                &mut hits.accel
            }
            Contamination::VectorClipping => {
                saturate(samples.iter_mut().map(|s| &mut s.mag_ut).collect(), &mut random);
                &mut hits.mag
            }
            Contamination::GyroBursts | Contamination::GyroClipping => {
                rectified_vibration(samples, &mut random);
                &mut hits.gyro
            }
        };
        mask.get_mut(burst).unwrap_or_default().fill(true);
    }
    (hit, hits)
}

/// Properties that all bursts of a trace share.
struct Source {
    axis: Vector3<f64>,
    steel: Matrix3<f64>,
}

/// Bursts that do not overlap and together cover `share` of the window to the sample. Lengths are drawn
/// first; the pauses between them split the rest at uniform points.
fn bursts(window: &Range<usize>, share: f64, period_s: f64, random: &mut Random) -> Vec<Range<usize>> {
    let target = (share * window.len() as f64).round() as usize;
    let mut lengths = Vec::new();
    let mut covered = 0;
    while covered < target {
        let length = (random.between(BURST_S[0], BURST_S[1]) / period_s).round() as usize;
        let length = length.clamp(1, target - covered);
        lengths.push(length);
        covered += length;
    }
    let free = window.len() - covered;
    let mut cuts: Vec<usize> = lengths.iter().map(|_| (random.uniform() * (free as f64 + 1.0)) as usize).collect();
    cuts.sort_unstable();
    let mut before = 0;
    let place = |(&length, &cut): (&usize, &usize)| {
        let start = window.start + cut + before;
        before += length;
        start..start + length
    };
    lengths.iter().zip(&cuts).map(place).collect()
}

/// Adds to a reading in double precision.
fn add(reading: &mut [f32; 3], offset: &Vector3<f64>) {
    for (x, o) in reading.iter_mut().zip(offset.iter()) {
        *x = (f64::from(*x) + o) as f32;
    }
}

/// Adds an offset to each reading of a burst, growing over its first fifth and fading over its last.
fn add_in_and_out<'a>(
    readings: impl ExactSizeIterator<Item = &'a mut [f32; 3]>,
    offset: impl Fn(Vector3<f64>) -> Vector3<f64>,
) {
    let count = readings.len() as f64;
    for (k, reading) in readings.enumerate() {
        let place = (k as f64 + 0.5) / count;
        let swell = (5.0 * place.min(1.0 - place)).min(1.0);
        let now = Vector3::from(reading.map(f64::from));
        add(reading, &(offset(now) * swell));
    }
}

fn casing_joint(samples: &mut [Sample], attitudes: &[Option<[f64; 4]>], random: &mut Random) {
    let extra_ut = Vector3::from(random.direction()) * random.between(5.0, 40.0);
    let gain = random.between(-0.3, 0.3);
    let count = samples.len() as f64;
    for (k, (sample, attitude)) in samples.iter_mut().zip(attitudes).enumerate() {
        let [w, x, y, z] = attitude.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let attitude = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let place = (k as f64 + 0.5) / count;
        let swell = (5.0 * place.min(1.0 - place)).min(1.0);
        let own = Vector3::from(sample.mag_ut.map(f64::from));
        add(&mut sample.mag_ut, &((attitude.inverse_transform_vector(&extra_ut) + own * gain) * swell));
    }
}

/// Mean that an accelerometer shows under heavy vibration without a mean: 50 mg.
const RECTIFIED_M_S2: f64 = 0.05 * STANDARD_GRAVITY_M_S2;

fn shock_train(samples: &mut [Sample], period_s: f64, random: &mut Random) {
    let direction = Vector3::from(random.direction());
    let per_second = random.between(5.0, 25.0);
    let decay_s = random.between(0.02, 0.06);
    let mut acceleration = Vector3::zeros();
    for (k, sample) in samples.iter_mut().enumerate() {
        acceleration *= libm::exp(-period_s / decay_s);
        if k == 0 || random.uniform() < per_second * period_s {
            let scatter = Vector3::from(random.direction()) * 0.3;
            acceleration += (direction + scatter) * (STANDARD_GRAVITY_M_S2 * random.between(2.0, 10.0));
        }
        add(&mut sample.accel_m_s2, &(acceleration + direction * RECTIFIED_M_S2));
    }
}

/// Clamps every axis to a scale that the largest axis of every reading of the burst exceeds.
fn saturate(mut readings: Vec<&mut [f32; 3]>, random: &mut Random) {
    let largest = |reading: &[f32; 3]| reading.iter().fold(0.0_f64, |most, x| most.max(f64::from(x.abs())));
    let least = readings.iter().map(|reading| largest(reading)).fold(f64::INFINITY, f64::min);
    let limit = (random.between(0.3, 0.7) * least) as f32;
    for x in readings.iter_mut().flat_map(|reading| reading.iter_mut()) {
        if x.abs() > limit {
            *x = limit.copysign(*x);
        }
    }
}

fn clip_gyro(samples: &mut [Sample], share: f64, window: &Range<usize>, mask: &mut [bool]) {
    let largest = |s: &Sample| s.gyro_rad_s.iter().fold(0.0_f32, |most, x| if x.abs() > most { x.abs() } else { most });
    let mut rates: Vec<f32> = samples.get(window.clone()).unwrap_or_default().iter().map(largest).collect();
    rates.sort_by(f32::total_cmp);
    let clipped = (share * rates.len() as f64).round() as usize;
    let Some(&limit) = rates.len().checked_sub(clipped + 1).and_then(|k| rates.get(k)) else { return };
    for (sample, hit) in samples.iter_mut().zip(mask).take(window.end).skip(window.start) {
        *hit = largest(sample) > limit;
        for x in sample.gyro_rad_s.iter_mut().filter(|x| x.abs() > limit) {
            *x = limit.copysign(*x);
        }
    }
}

fn rectified_vibration(samples: &mut [Sample], random: &mut Random) {
    let offset = Vector3::from(random.direction()) * random.between(2.0, 20.0).to_radians();
    let spiky = random.uniform() < 0.5;
    for sample in samples {
        let mut disturbance = offset * (1.0 + 0.3 * libm::sin(TAU * random.uniform()));
        if spiky && random.uniform() < 0.2 {
            disturbance += Vector3::from(random.direction()) * random.between(50.0, 500.0).to_radians();
        }
        add(&mut sample.gyro_rad_s, &disturbance);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::simulate::{Scenario, simulate};

    #[test]
    fn the_share_is_met_what_is_hit_differs_and_the_rest_is_the_same_to_the_bit() {
        let scenario = Scenario { duration_s: 60.0, rest_s: 0.0, ..Scenario::default() };
        let (trace, _) = simulate(&scenario, 5);
        let window = 500..5_500;
        for kind in Contamination::ALL {
            for (seed, percent) in (0..).zip([10, 20, 30, 40, 50, 80]) {
                let share = f64::from(percent) * 0.01;
                let (hit, hits) = contaminate(&trace, kind, share, &window, seed);
                assert!((hits.share(&window) - share).abs() < 1e-3, "{kind:?} {percent} %: {}", hits.share(&window));
                assert_eq!(contaminate(&trace, kind, share, &window, seed), (hit.clone(), hits.clone()));
                for (k, (before, after)) in trace.samples.iter().zip(&hit.samples).enumerate() {
                    assert!(window.contains(&k) || !(hits.gyro[k] || hits.accel[k] || hits.mag[k]));
                    assert_eq!(before.gyro_rad_s != after.gyro_rad_s, hits.gyro[k], "{kind:?} gyro {k}");
                    assert_eq!(before.accel_m_s2 != after.accel_m_s2, hits.accel[k], "{kind:?} accelerometer {k}");
                    assert_eq!(before.mag_ut != after.mag_ut, hits.mag[k], "{kind:?} magnetometer {k}");
                }
            }
        }
    }

    #[test]
    fn bursts_lie_in_the_window_without_overlap_and_are_of_the_stated_lengths() {
        for seed in 0..50 {
            let bursts = bursts(&(100..5_100), 0.4, 0.01, &mut Random::new(seed));
            assert!(bursts.first().unwrap().start >= 100 && bursts.last().unwrap().end <= 5_100);
            assert!(bursts.windows(2).all(|pair| pair[0].end <= pair[1].start));
            assert_eq!(bursts.iter().map(ExactSizeIterator::len).sum::<usize>(), 2_000);
            // The last burst is cut to reach the share.
            assert!(bursts[..bursts.len() - 1].iter().all(|b| (10..=500).contains(&b.len())));
        }
    }
}
