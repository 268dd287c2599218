//! A remainder is named if it is there, and hardly ever if it is not.

extern crate std;

use super::*;
use core::f32::consts::TAU;
use nalgebra::Rotation3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

/// Nodes of 50 s.
const NODES: usize = 100;
const NODE_S: f32 = 0.5;
const INCREMENTS: usize = 4;

/// Sum of four uniform deviates: near enough to a normal one; deviation 1.
fn deviate(generator: &mut Xoshiro128PlusPlus) -> f32 {
    let sum: f32 = (0..4).map(|_| generator.next_u32() as f32 / u32::MAX as f32 - 0.5).sum();
    sum * libm::sqrtf(3.0)
}

fn vector(generator: &mut Xoshiro128PlusPlus) -> Vector3<f32> {
    Vector3::from_fn(|_, _| deviate(generator))
}

#[test]
fn a_remainder_that_is_forgotten_is_as_new() {
    let mut remainder = Remainder::zero();
    (0..120).for_each(|_| remainder.add(NODE_S, [Vector3::new(3.0, 3.0, 3.0); 2]));
    remainder.start();
    assert!((remainder.dispersion() - 9.0).abs() < 0.01);
    remainder.forget();
    remainder.add(NODE_S, [Vector3::new(1.0, 1.0, 1.0); 2]);
    assert!((remainder.dispersion() - 1.0).abs() < 0.01, "{}", remainder.dispersion());
}

/// Innovations of the field with the variance that they should have, as turns and as vectors.
#[test]
fn the_dispersion_of_noise_as_it_is_stated_is_1() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(2);
    let mut remainder = Remainder::zero();
    let mut mean = 0.0;
    for _ in 0..4_000 {
        let innovation = vector(&mut generator);
        remainder.add(NODE_S, [Vector3::new(0.5, 0.0, -0.866).cross(&innovation), innovation]);
        mean += remainder.dispersion() / 4_000.0;
    }
    assert!((mean - 1.0_f32).abs() < 0.05, "{mean}");
}

/// Random conditions, independent of one another as far as gravity allows.
fn conditions(generator: &mut Xoshiro128PlusPlus) -> Snapshot {
    let toolface = generator.next_u32() as f32 / u32::MAX as f32 * TAU;
    let across = libm::expf(deviate(generator));
    let force = Vector3::new(across * libm::cosf(toolface), across * libm::sinf(toolface), 9.0 + deviate(generator));
    Snapshot {
        rate_rad_s: vector(generator) + Vector3::new(0.0, 0.0, 1.0),
        acceleration_rad_s2: vector(generator) * 3.0,
        force_m_s2: force,
        square_force_m2_s4: 200.0 + 20.0 * deviate(generator),
        field_ut: vector(generator) * 30.0,
        warming_k: 40.0 + deviate(generator),
    }
}

/// A moment of a node: its conditions change a little from increment to increment.
fn stirred(conditions: &Snapshot, generator: &mut Xoshiro128PlusPlus) -> Snapshot {
    Snapshot {
        rate_rad_s: conditions.rate_rad_s + vector(generator) * 0.1,
        acceleration_rad_s2: conditions.acceleration_rad_s2 + vector(generator) * 0.1,
        ..*conditions
    }
}

/// Innovations of a run: white noise of these deviations of the body's axes, of 1 in the earth's frame, and the
/// addition of `add` in each increment, given its snapshot, its rotation and the node's number.
fn told(
    seed: u64,
    deviations: [f32; 3],
    mut add: impl FnMut(&Snapshot, &Matrix3<f32>, usize) -> [Vector3<f32>; 2],
) -> Remainder {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
    let mut remainder = Remainder::zero();
    remainder.start();
    for node in 0..NODES {
        remainder.start_node();
        let of_node = conditions(&mut generator);
        let mut sums = [vector(&mut generator).component_mul(&Vector3::from(deviations)), vector(&mut generator)];
        for _ in 0..INCREMENTS {
            let moment = stirred(&of_node, &mut generator);
            let rotation = *Rotation3::from_scaled_axis(vector(&mut generator)).matrix();
            remainder.watch(&moment, &rotation);
            for (sum, part) in sums.iter_mut().zip(add(&moment, &rotation, node)) {
                *sum += part / INCREMENTS as f32;
            }
        }
        remainder.add(NODE_S, sums);
    }
    remainder
}

fn said(seed: u64, add: impl FnMut(&Snapshot, &Matrix3<f32>, usize) -> [Vector3<f32>; 2]) -> RemainderReport {
    told(seed, [1.0; 3], add).report()
}

const NONE: Vector3<f32> = Vector3::new(0.0, 0.0, 0.0);
/// A direction in which a remainder lies.
const ALONG: Vector3<f32> = Vector3::new(2.0, -1.0, 2.0);

#[test]
fn a_white_remainder_is_named_once_in_a_hundred_at_most() {
    let runs = 2_000;
    // All axes alike, and all of it about one axis.
    for deviations in [[1.0; 3], [1.0, 0.1, 0.1], [1e-3, 2e-3, 1e-3]] {
        let reports = (0..runs).map(|seed| told(seed, deviations, |_, _, _| [NONE; 2]).report());
        let alarms = reports.filter(|report| !report.is_white()).count();
        // Expected are 20 +- 4.5 alarms.
        assert!(alarms <= 33, "{alarms} of {runs}, {deviations:?}");
    }
}

#[test]
fn each_quantity_is_recognised() {
    let toolface = |moment: &Snapshot| libm::atan2f(moment.force_m_s2.y, moment.force_m_s2.x);
    for seed in 0..50 {
        let named_first = |correlate, is_of_earth: bool, size: &dyn Fn(&Snapshot, &Matrix3<f32>) -> f32| {
            let report = said(seed, |moment, rotation, _| {
                let part = ALONG * size(moment, rotation);
                if is_of_earth { [NONE, part] } else { [part, NONE] }
            });
            let first = report.goes_with[0];
            assert_eq!(first.correlate, correlate, "{seed}: {report:?}");
            assert!(report.count >= 1 && (0.2..0.97).contains(&first.share), "{seed}: {report:?}");
            assert!(!report.is_white());
        };
        named_first(Correlate::Temperature, false, &|moment, _| moment.warming_k - 40.0);
        named_first(Correlate::Rate, false, &|moment, _| moment.rate_rad_s.y);
        // Rates are about (0, 0, 1): what goes with their square goes with the rate as well, unless that is taken off.
        let beside_rate = |moment: &Snapshot, _: &Matrix3<f32>| (moment.rate_rad_s - Vector3::z()).norm_squared();
        named_first(Correlate::RateSquared, false, &|moment, rotation| 0.5 * beside_rate(moment, rotation));
        named_first(Correlate::Acceleration, false, &|moment, _| moment.force_m_s2.z);
        named_first(Correlate::VibrationPower, false, &|moment, _| 0.05 * moment.square_force_m2_s4);
        named_first(Correlate::OncePerRevolution, false, &|moment, _| 1.5 * libm::cosf(toolface(moment) - 1.0));
        named_first(Correlate::TwicePerRevolution, false, &|moment, _| 1.5 * libm::cosf(2.0 * toolface(moment) - 1.0));
        named_first(Correlate::Lag, true, &|moment, rotation| (rotation * moment.acceleration_rad_s2).z * 0.5);
    }
}

#[test]
fn a_step_goes_with_time_whichever_frame_it_is_in() {
    for seed in 0..50 {
        let at = 20 + seed as usize;
        for frame in 0..2 {
            let report = said(seed, |_, _, node| {
                let mut both = [NONE; 2];
                both[frame] = if node < at { NONE } else { ALONG };
                both
            });
            assert_eq!(report.named().next().map(|found| found.correlate), Some(Correlate::Time), "{seed}: {report:?}");
        }
    }
}

/// Time and what goes steadily with it cannot be told apart; both are named.
#[test]
fn a_drift_goes_with_time_and_with_what_drifts_as_well() {
    for seed in 0..50 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut remainder = Remainder::zero();
        for node in 0..NODES {
            let warming_k = 40.0 + 0.02 * node as f32;
            remainder.start_node();
            remainder.watch(&Snapshot { warming_k, ..conditions(&mut generator) }, &Matrix3::identity());
            remainder.add(NODE_S, [vector(&mut generator) + ALONG * (warming_k - 41.0), vector(&mut generator)]);
        }
        let report = remainder.report();
        let named: Vec<_> = report.named().map(|found| found.correlate).collect();
        assert!(named.contains(&Correlate::Time) && named.contains(&Correlate::Temperature), "{seed}: {report:?}");
    }
}

#[test]
fn what_comes_back_has_a_memory_of_half_its_period() {
    for seed in 0..50 {
        for period_s in [3.0, 5.0, 10.0] {
            let report = said(seed, |_, _, node| {
                [ALONG * libm::sinf(TAU * node as f32 * NODE_S / period_s + seed as f32), NONE]
            });
            let Memory { correlation, apart_s, .. } = report.memory;
            assert!(report.has_memory && correlation.abs() > 0.4, "{seed}: {report:?}");
            let halves = apart_s / period_s * 2.0;
            assert!((halves - halves.round()).abs() * period_s <= 1.01, "{seed}, {period_s} s: {report:?}");
            let is_opposite = halves.round() as u32 % 2 == 1;
            assert_eq!(correlation < 0.0, is_opposite, "{seed}, {period_s} s: {report:?}");
        }
    }
}

#[test]
fn what_lingers_and_what_alternates_have_a_memory_of_a_node() {
    for kept in [0.6, -0.6] {
        let mut found = Vec::new();
        for seed in 0..50 {
            let mut generator = Xoshiro128PlusPlus::seed_from_u64(1_000 + seed);
            let mut remainder = Remainder::zero();
            let mut innovation = NONE;
            for _ in 0..NODES {
                innovation = innovation * kept + vector(&mut generator);
                remainder.start_node();
                remainder.watch(&conditions(&mut generator), &Matrix3::identity());
                remainder.add(NODE_S, [innovation, vector(&mut generator)]);
            }
            let report = remainder.report();
            assert!(report.has_memory, "{seed}: {report:?}");
            assert_eq!(report.memory.apart_s, NODE_S, "{seed}: {report:?}");
            found.push(report.memory.correlation);
        }
        let mean = found.iter().sum::<f32>() / found.len() as f32;
        assert!((mean - kept).abs() < 0.05, "{mean} of {kept}");
    }
}

#[test]
fn its_unit_changes_nothing() {
    let add = |moment: &Snapshot, unit: f32| [ALONG * moment.force_m_s2.z * unit, NONE];
    let a = told(1, [1.0; 3], |moment, _, _| add(moment, 1.0)).report();
    let b = told(1, [1e-4; 3], |moment, _, _| add(moment, 1e-4)).report();
    assert_eq!(a.goes_with[0].correlate, b.goes_with[0].correlate);
    assert!((a.goes_with[0].share - b.goes_with[0].share).abs() < 1e-3 && a.count == b.count, "{a:?} {b:?}");
    assert!((a.memory.correlation - b.memory.correlation).abs() < 1e-3, "{a:?} {b:?}");
}

#[test]
fn nothing_is_said_of_nothing_and_a_start_forgets() {
    let nothing = Remainder::zero().report();
    assert!(nothing.is_white() && nothing.memory.correlation == 0.0, "{nothing:?}");
    let mut remainder = told(2, [1.0; 3], |moment, _, _| [moment.force_m_s2, NONE]);
    assert!(!remainder.report().is_white());
    remainder.start();
    assert_eq!(remainder.report(), nothing);
    assert!(size_of::<Remainder>() <= 1_024, "{}", size_of::<Remainder>());
}
