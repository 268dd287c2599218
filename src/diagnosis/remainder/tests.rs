extern crate std;

use super::{correlation::REGRESSORS, *};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::{vec, vec::Vec};

/// Steps of the underlying noise in a hop.
const FINE: usize = 4;

/// Test windows of a diagnosis of 36 s.
const TESTS: usize = 69;

/// Sum of four uniform deviates: near enough to a normal one; deviation 1.
fn deviate(generator: &mut Xoshiro128PlusPlus) -> f32 {
    let sum: f32 = (0..4).map(|_| generator.next_u32() as f32 / u32::MAX as f32 - 0.5).sum();
    sum * libm::sqrtf(3.0)
}

/// White noise as test windows see it: by sin^2 weights that overlap fourfold, or by their slope.
fn seen(generator: &mut Xoshiro128PlusPlus, by_slope: bool) -> Vec<f32> {
    let white: Vec<f32> = (0..(TESTS + 4) * FINE).map(|_| deviate(generator)).collect();
    let length = 4 * FINE;
    let weight = |k: usize| {
        let angle = core::f32::consts::PI * (k as f32 + 0.5) / length as f32;
        let sine = libm::sinf(angle);
        if by_slope { 0.35 * libm::sinf(2.0 * angle) } else { 0.41 * sine * sine }
    };
    (0..TESTS).map(|test| (0..length).map(|k| weight(k) * white[test * FINE + k]).sum()).collect()
}

/// Conditions that are white themselves, seen by the same windows; time is what it is.
fn conditions(generator: &mut Xoshiro128PlusPlus) -> Vec<[f32; REGRESSORS]> {
    let mut all = vec![[0.0; REGRESSORS]; TESTS];
    for k in 2..REGRESSORS {
        for (regressors, x) in all.iter_mut().zip(seen(generator, false)) {
            regressors[k] = 30.0 + x;
        }
    }
    for (number, regressors) in all.iter_mut().enumerate() {
        let time = number as f32 / 32.0 - 1.0;
        (regressors[0], regressors[1]) = (time, time * time);
        // It warms up steadily.
        regressors[2] = 40.0 + 0.02 * number as f32;
    }
    all
}

/// What is said of residuals that are drawn at random and to which `add` adds.
fn said(seed: u64, by_slope: bool, add: impl Fn(&[f32; REGRESSORS], usize) -> [Vector3<f32>; 2]) -> RemainderReport {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let conditions = conditions(&mut generator);
    let mut remainder = Remainder::zero();
    remainder.start(25, 0.02);
    let noise: Vec<Vec<f32>> = (0..6).map(|_| seen(&mut generator, by_slope)).collect();
    for (number, regressors) in conditions.iter().enumerate() {
        let noise: [f32; 6] = core::array::from_fn(|k| noise[k][number]);
        let [x, y, z, u, v, w] = noise;
        let [body, earth] = add(regressors, number);
        let residuals = [Vector3::new(x, y, z) + body, Vector3::new(u, v, w) + earth];
        remainder.moments.add(regressors, &residuals);
        remainder.whiteness.add(number, &residuals[0]);
    }
    remainder.report()
}

const NONE: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);

#[test]
fn a_white_remainder_is_named_once_in_a_hundred_at_most() {
    let runs = 4_000;
    for by_slope in [false, true] {
        let reports = (0..runs).map(|seed| said(seed, by_slope, |_, _| [NONE; 2]));
        let alarms = reports.filter(|report| !report.is_white()).count();
        // 40 +- 6.3.
        assert!(alarms <= 59, "{alarms} of {runs}");
    }
}

#[test]
fn each_quantity_is_recognised() {
    let columns = [
        (Correlate::Rate, 4, false),
        (Correlate::RateSquared, 6, false),
        (Correlate::Acceleration, 8, false),
        (Correlate::VibrationPower, 10, false),
        (Correlate::OncePerRevolution, 11, false),
        (Correlate::TwicePerRevolution, 14, false),
        (Correlate::Lag, 16, true),
    ];
    for (correlate, column, is_in_earth) in columns {
        for seed in 0..50 {
            let report = said(seed, false, |x, _| {
                let part = Vector3::new(2.0, -1.0, 2.0) * (x[column] - 30.0);
                if is_in_earth { [NONE, part] } else { [part, NONE] }
            });
            assert_eq!(report.goes_with[0].correlate, correlate, "{seed}: {report:?}");
            assert!(report.count >= 1 && (0.4..0.95).contains(&report.goes_with[0].share), "{seed}: {report:?}");
        }
    }
}

/// Time and what goes steadily with it cannot be told apart; both are named.
#[test]
fn a_drift_goes_with_time_and_with_what_drifts_as_well() {
    for seed in 0..50 {
        let report = said(seed, false, |x, _| [Vector3::new(0.0, 1.0, 4.0) * (x[2] - 40.7), NONE]);
        let named: Vec<_> = report.named().map(|found| found.correlate).collect();
        assert!(named.contains(&Correlate::Time) && named.contains(&Correlate::Temperature), "{seed}: {report:?}");
    }
}

#[test]
fn what_comes_back_has_a_memory_of_half_its_period() {
    for seed in 0..50 {
        let report = said(seed, false, |_, number| {
            let phase = core::f32::consts::TAU * number as f32 / 14.0;
            [Vector3::new(1.0, -1.0, 0.5) * libm::sinf(phase) * 2.5, NONE]
        });
        assert!(report.has_memory && report.memory.correlation.abs() > 0.5, "{seed}: {report:?}");
        let multiples = report.memory.apart_s / 3.5;
        assert!((multiples - multiples.round()).abs() < 0.3, "{seed}: {report:?}");
    }
}

#[test]
fn nothing_is_said_of_nothing() {
    let report = Remainder::zero().report();
    assert!(report.is_white() && report.memory.correlation == 0.0, "{report:?}");
    assert!(size_of::<Remainder>() <= 1_024, "{}", size_of::<Remainder>());
}
