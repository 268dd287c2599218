//! A probe that is configured again gives the outputs of a new one; lost samples, another library, and since when a
//! model flies.

extern crate std;

use super::*;
use crate::{
    attitude::AttitudeFlags,
    compensation::effects,
    config::{IdentificationConfig, Latency, Motion},
    identification::Decision,
};
use core::fmt::Write;
use nalgebra::{UnitQuaternion, Vector3, Vector4};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{boxed::Box, string::String, vec::Vec};

/// 100 Hz.
const PERIOD_US: u64 = 10_000;

/// Samples of a probe that tumbles in place: a gyro with a scale error and a bias, a magnetometer that lags
/// by 15 ms, and a magnet from the 25th to the 45th second.
fn tumbling(seconds: u64) -> Vec<Sample> {
    tumbling_with(seconds, 1.0).into_iter().map(|(sample, _)| sample).collect()
}

/// Samples of [`tumbling`] with its errors scaled by `errors`, each with the true attitude, body to NED.
fn tumbling_with(seconds: u64, errors: f64) -> Vec<(Sample, UnitQuaternion<f64>)> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(11);
    let mut noise = move || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let rate_at = |t: f64| {
        let sine = |hz: f64, phase: f64| libm::sin(core::f64::consts::TAU * hz * t + phase);
        let moving = Vector3::new(1.2 * sine(0.21, 0.3) + 0.3, sine(0.17, 1.7) - 0.2, 1.5 * sine(0.13, 2.9) + 0.4);
        if t < 4.0 { Vector3::zeros() } else { moving }
    };
    let mut attitude = UnitQuaternion::<f64>::identity();
    let mut sample_at = |k: u64| {
        let t = k as f64 * 0.01;
        let rate = rate_at(t);
        let magnet = if (25.0..45.0).contains(&t) { Vector3::new(6.0, -4.0, 9.0) * errors } else { Vector3::zeros() };
        let earlier = attitude * UnitQuaternion::from_scaled_axis(-rate * (0.015 * errors));
        let now = attitude;
        let force = attitude.inverse_transform_vector(&Vector3::new(0.0, 0.0, -9.806_65));
        let field = earlier.inverse_transform_vector(&Vector3::new(20.0, 0.0, 45.0)) + magnet;
        attitude *= UnitQuaternion::from_scaled_axis(rate_at(t + 0.005) * 0.01);
        let mut noisy = |v: Vector3<f64>, width: f64| v.map(|x| (x + width * noise()) as f32).into();
        let bias = Vector3::new(0.01, -0.02, 0.015) * errors;
        let sample = Sample {
            t_us: k * PERIOD_US,
            gyro_rad_s: noisy(rate * (1.0 + 0.05 * errors) + bias, 0.004),
            accel_m_s2: noisy(force, 0.05),
            mag_ut: noisy(field, 0.5),
            temperature_c: 30.0,
            flags: SampleFlags::empty(),
        };
        (sample, now)
    };
    (0..seconds * 100).map(&mut sample_at).collect()
}

/// Samples of random bit patterns, flags included; time goes forward by up to five sample periods.
fn random_samples(from_us: u64) -> impl Iterator<Item = Sample> {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(12);
    let mut t_us = from_us;
    (0..2_000).map(move |_| {
        t_us += 1 + u64::from(random.next_u32()) % (5 * PERIOD_US);
        let mut vector = || [0; 3].map(|_| f32::from_bits(random.next_u32()));
        let [gyro_rad_s, accel_m_s2, mag_ut] = [vector(), vector(), vector()];
        let flags = SampleFlags::from_bits_truncate(random.next_u32() as u16 & random.next_u32() as u16);
        Sample { t_us, gyro_rad_s, accel_m_s2, mag_ut, temperature_c: f32::from_bits(random.next_u32()), flags }
    })
}

/// All outputs of a probe for a sample, as text that is exact to the last bit.
fn said(probe: &mut Probe, sample: &Sample) -> String {
    let mut said = String::new();
    let output = probe.push(sample);
    let survey = output.map(|output| probe.survey_input(sample, &output));
    let report = probe.poll(probe.poll_budget());
    let diagnosis = probe.take_diagnosis();
    write!(said, "{output:?} {survey:?} {report:?} {diagnosis:?} {:?} {:?}", probe.counters(), probe.gyro_model())
        .unwrap();
    let intervals: Vec<_> = probe.hard_iron_intervals().collect();
    write!(said, " {:?} {intervals:?} {:?}", probe.effects(), probe.hard_iron_counts()).unwrap();
    said
}

/// A probe with a history: an accepted model, effects, a magnet, then random samples.
fn with_a_history(config: &Config, samples: &[Sample]) -> Box<Probe> {
    let mut probe = Box::new(Probe::new());
    probe.configure(config).unwrap();
    let mut accepted = 0;
    for sample in samples {
        probe.push(sample);
        let report = probe.poll(probe.poll_budget());
        accepted += u32::from(report.is_some_and(|report| report.decision == Decision::Accepted));
    }
    assert!(accepted > 0 && *probe.gyro_model() != config.gyro, "the history must have an accepted model");
    assert!(probe.mag_delay_sigma_s().is_some(), "and the magnetometer's delay: {:?}", probe.effects());
    assert!(probe.hard_iron_counts().intervals > 0, "and a magnet: {:?}", probe.hard_iron_counts());
    probe
}

fn assert_flies_as_a_new_one(used: &mut Probe, config: &Config, samples: &[Sample]) {
    let mut new = Box::new(Probe::new());
    new.configure(config).unwrap();
    for (k, sample) in samples.iter().enumerate() {
        assert_eq!(said(used, sample), said(&mut new, sample), "sample {k}");
    }
}

#[test]
fn a_probe_that_is_configured_again_flies_as_a_new_one() {
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let samples = tumbling(90);
    let mut used = with_a_history(&config, &samples);
    used.configure(&config).unwrap();
    assert_flies_as_a_new_one(&mut used, &config, &samples);
}

#[test]
fn other_settings_in_between_leave_nothing_behind() {
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let samples = tumbling(90);
    let mut used = with_a_history(&config, &samples);
    for sample in random_samples(100_000_000) {
        used.push(&sample);
        used.poll(10);
    }
    let mut other = Config { sample_period_us: 5_000, seed: 7, effects: false, ..config };
    other.identification = IdentificationConfig { motion: Motion::Hand, ..config.identification };
    other.latency = Latency { gyro_s: Some(0.004), accel_s: Some(0.002), mag_s: Some(0.01) };
    other.earth.declination_rad = Some(0.2);
    other.earth.latitude_rad = Some(1.0);
    used.set_library(&[&effects::GyroLag]);
    used.configure(&other).unwrap();
    for sample in samples.iter().take(1_500).copied().chain(random_samples(20_000_000)) {
        used.push(&sample);
        used.poll(used.poll_budget());
    }
    used.set_library(&effects::LIBRARY);
    used.configure(&config).unwrap();
    assert_flies_as_a_new_one(&mut used, &config, &samples);
}

#[test]
fn what_was_lost_stays_counted_when_the_clock_goes_back() {
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    let samples = tumbling(70);
    // Nothing is identified.
    for sample in &samples {
        probe.push(sample);
    }
    let before = probe.counters();
    assert!(before.increments_lost > 0 && before.overruns > 0, "{before:?}");
    for sample in &samples[1..11] {
        probe.push(sample);
    }
    let after = probe.counters();
    assert_eq!(after.samples, before.samples + 9, "the first stamp that is back is not believed");
    assert_eq!([after.increments_lost, after.overruns], [before.increments_lost, before.overruns]);
}

#[test]
fn a_change_of_the_model_is_no_angular_acceleration() {
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let mut probe = Box::new(Probe::new());
    probe.configure(&config).unwrap();
    let samples = tumbling(10);
    for sample in &samples {
        probe.push(sample);
    }
    let other = GyroModel { p: [[1.1, 0.02, 0.0], [0.0, 0.9, 0.0], [-0.03, 0.0, 1.05]], b_rad_s: [0.02, 0.0, -0.01] };
    // The next reading is the same.
    let rate = other.compensate(samples[999].gyro_rad_s);
    assert!(rate.norm() > 0.5, "it turns: {rate}");
    assert_eq!(probe.pipeline.corrector.rate_before(&other, Vector3::zeros()), rate);
}

/// Each report then tells of nothing but the samples since, though these have hardly any motion that can be used.
#[test]
fn without_a_sensor_nothing_is_told_of_the_configuration_before() {
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let samples = tumbling(90);
    for missing in [SampleFlags::GYRO_MISSING, SampleFlags::ACCEL_MISSING, SampleFlags::MAG_MISSING] {
        let mut used = with_a_history(&config, &samples);
        used.freeze(91_000_000);
        used.configure(&config).unwrap();
        let without: Vec<_> = samples.iter().take(6_000).map(|sample| Sample { flags: missing, ..*sample }).collect();
        assert_flies_as_a_new_one(&mut used, &config, &without);
    }
}

/// Flying effects are stored as places in the library: another library must not turn them into others in flight.
#[cfg(feature = "storage")]
#[test]
fn another_library_takes_effect_with_the_next_configuration() {
    use crate::storage::{StoreReason, StoredModel, fingerprint};
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let fly = |change: bool| {
        let mut probe = Box::new(Probe::new());
        probe.configure(&config).unwrap();
        let mut model = StoredModel {
            gyro: config.gyro,
            sigma: [0.01; 12],
            effects: crate::compensation::ActiveEffects::none(),
            library: fingerprint(&effects::LIBRARY, &config),
            temperature_c: None,
            t_us: 1,
            reason: StoreReason::Command,
        };
        let mut found = crate::compensation::FoundEffect { index: 0, ..Default::default() };
        (found.parameters[0], found.sigma[0]) = (0.015, 0.001);
        assert!(model.effects.add(found));
        probe.restore(&model).unwrap();
        let mut heard = String::new();
        for (k, sample) in tumbling(10).iter().enumerate() {
            if change && k == 500 {
                probe.set_library(&[&effects::HardIron]);
            }
            heard += &std::format!("{:?}\n", probe.push(sample));
        }
        (heard, probe)
    };
    let ((kept, _), (changed, mut probe)) = (fly(false), fly(true));
    assert!(kept == changed, "the flying effect became another one");
    assert_eq!(probe.library().len(), effects::LIBRARY.len());
    probe.configure(&config).unwrap();
    assert_eq!(probe.library().len(), 1);
    assert!(probe.effects().is_empty());
}

/// A bias of the accelerometer leans the tilt by its share of gravity, iron turns the heading by its share of the
/// horizontal field: by as much as is not known of what is taken out the attitude is uncertain.
#[cfg(feature = "storage")]
#[test]
fn attitudes_are_no_more_certain_than_what_is_taken_out() {
    use crate::storage::{StoreReason, StoredModel, fingerprint};
    let config = Config { sample_period_us: PERIOD_US as u32, ..Config::default() };
    let sigmas = |name: &str, sigma: f32| {
        let index = effects::LIBRARY.iter().position(|effect| effect.name() == name).unwrap();
        let mut found = crate::compensation::FoundEffect { index: index as u8, ..Default::default() };
        // A parameter of zero is not taken out.
        found.parameters[..3].fill(1e-6);
        found.sigma[..3].fill(sigma);
        let mut taken_out = crate::compensation::ActiveEffects::none();
        assert!(taken_out.add(found));
        let model = StoredModel {
            gyro: config.gyro,
            sigma: [1e-4; 12],
            effects: taken_out,
            library: fingerprint(&effects::LIBRARY, &config),
            temperature_c: None,
            t_us: 1,
            reason: StoreReason::Command,
        };
        let mut probe = Box::new(Probe::new());
        probe.configure(&config).unwrap();
        probe.restore(&model).unwrap();
        let to_body = UnitQuaternion::<f64>::from_euler_angles(0.3, -0.5, 0.7).inverse();
        let mut random = Xoshiro128PlusPlus::seed_from_u64(13);
        let mut read = |v: Vector3<f64>, width: f64| -> [f32; 3] {
            (to_body * v)
                .map(|x| (x + width * (f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5)) as f32)
                .into()
        };
        let mut last = None;
        for k in 0..2_000 {
            let sample = Sample {
                t_us: k * PERIOD_US,
                gyro_rad_s: read(Vector3::zeros(), 0.004),
                accel_m_s2: read(Vector3::new(0.0, 0.0, -9.806_65), 0.05),
                mag_ut: read(Vector3::new(20.0, 0.0, 45.0), 0.5),
                temperature_c: 30.0,
                flags: SampleFlags::empty(),
            };
            last = probe.push(&sample).and_then(|output| output.attitude);
        }
        let attitude = last.unwrap();
        [attitude.sigma_inclination_rad, attitude.sigma_azimuth_rad]
    };
    let [inclination, _] = sigmas("accel_bias", 0.0);
    let [leant, _] = sigmas("accel_bias", 0.1);
    let expected = libm::hypotf(inclination, 0.1 / 9.806_65);
    assert!((leant / expected - 1.0).abs() < 0.05, "{leant} {expected}");
    let [_, azimuth] = sigmas("hard_iron", 0.0);
    let [_, turned] = sigmas("hard_iron", 2.0);
    let expected = libm::hypotf(azimuth, 2.0 / 20.0);
    // Part of it counts twice: in the mean of the field, and as an error of each reading.
    assert!((1.0..1.2).contains(&(turned / expected)), "{turned} {expected}");
}

#[test]
fn lost_samples_turn_the_attitude_by_less_than_it_says() {
    let latency = Latency { gyro_s: Some(0.0), accel_s: Some(0.0), mag_s: Some(0.0) };
    let config = Config { sample_period_us: PERIOD_US as u32, latency, ..Config::default() };
    let mut whole_told = f32::INFINITY;
    for lost_us in [0, 20_000, 50_000, 100_000] {
        let mut probe = Box::new(Probe::new());
        probe.configure(&config).unwrap();
        let (mut most, mut most_told) = (0.0_f32, 0.0_f32);
        for (sample, truth) in tumbling_with(24, 0.0) {
            if sample.t_us % 2_000_000 < lost_us {
                continue;
            }
            let Some(attitude) = probe.push(&sample).and_then(|output| output.attitude) else { continue };
            if sample.t_us < 6_000_000 {
                continue;
            }
            let [a, b] = [attitude.q.map(f64::from), [truth.w, truth.i, truth.j, truth.k]].map(Vector4::from);
            let angle = 2.0 * libm::acos(a.dot(&b).abs().min(1.0)) as f32;
            let told = libm::hypotf(attitude.sigma_inclination_rad, attitude.sigma_azimuth_rad);
            assert!(angle < 3.0 * told, "{lost_us}: {angle} {told} at {}", sample.t_us);
            most = if angle > most { angle } else { most };
            most_told = if told > most_told { told } else { most_told };
        }
        // In each loss of samples the probe turns by up to 15 deg.
        assert!(most < 0.05 && most_told < 1.5 * whole_told, "{lost_us}: {most} {most_told} {whole_told}");
        whole_told = if lost_us == 0 { most_told } else { whole_told };
    }
}

#[test]
fn a_model_flies_since_the_sample_at_which_it_changed() {
    let mut probe = Box::new(Probe::new());
    probe.configure(&Config { sample_period_us: 10_000, ..Config::default() }).unwrap();
    let mut changes = 0;
    let mut since_us = None;
    for sample in tumbling(60) {
        let before = *probe.gyro_model();
        let _ = probe.push(&sample);
        while probe.poll(u32::MAX).is_some() {}
        if *probe.gyro_model() != before {
            (changes, since_us) = (changes + 1, Some(sample.t_us));
        }
        assert_eq!(probe.model_since_us(), since_us);
    }
    assert!(changes > 1, "{changes}");
}

#[test]
fn a_freeze_outlasts_a_clock_that_goes_back() {
    let mut probe = Box::new(Probe::new());
    probe.configure(&Config { sample_period_us: PERIOD_US as u32, ..Config::default() }).unwrap();
    probe.freeze(40_000_000);
    for sample in tumbling(20) {
        let _ = probe.push(&sample);
    }
    let mut began = 0;
    for sample in tumbling(2) {
        let _ = probe.push(&sample);
        began += u32::from(probe.began_afresh());
    }
    assert_eq!((began, probe.frozen_at_us()), (1, Some(40_000_000)));
}

#[test]
fn a_sample_with_a_fault_is_not_used_and_the_next_is() {
    let mut probe = Box::new(Probe::new());
    probe.configure(&Config { sample_period_us: PERIOD_US as u32, ..Config::default() }).unwrap();
    let unused = AttitudeFlags::FAULT
        .union(AttitudeFlags::GYRO_HELD)
        .union(AttitudeFlags::ACCEL_UNUSED)
        .union(AttitudeFlags::MAG_UNUSED);
    for (k, (mut sample, _)) in tumbling_with(12, 0.0).into_iter().enumerate() {
        sample.flags.set(SampleFlags::FAULT, k == 1_000);
        let attitude = probe.push(&sample).and_then(|output| output.attitude);
        if k >= 990 {
            let told = attitude.unwrap().flags & unused;
            assert_eq!(told, if k == 1_000 { unused } else { AttitudeFlags::empty() }, "{k}");
        }
    }
}
