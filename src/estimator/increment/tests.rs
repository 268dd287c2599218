//! Increments are uncertain by what was not read.

use super::*;
use crate::compensation::GyroModel;
extern crate std;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

/// Sum over the increments of a steady turn at 100 Hz, in which one rate is read as told: variance of the turn, rad^2.
fn unread_turn(rate_rad_s: f32, told: Reading) -> f64 {
    let with = Composition::<f64>::new(&GyroModel::IDENTITY).unwrap();
    let mut builder = Builder::<f64>::zero();
    builder.start(0.01, false);
    let usable = |v: [f32; 3]| Reading::Usable(v.into());
    (0..100_u64)
        .filter_map(|k| {
            let rate = if k == 50 { told } else { usable([0.0, 0.0, rate_rad_s]) };
            let vectors = [usable([0.0, 0.0, -9.8]), usable([20.0, 0.0, 40.0])];
            builder.push((k * 10_000, 0.01), &with, [rate, vectors[0], vectors[1]])
        })
        .map(|item| match item {
            Item::Increment(increment) => increment.unread_turn,
            other => panic!("{other:?}"),
        })
        .sum()
}

#[test]
fn a_rate_beyond_the_full_scale_is_uncertain_by_itself_and_a_lost_one_by_less() {
    for rate_rad_s in [0.3, 2.0, 8.7] {
        let read = unread_turn(rate_rad_s, Reading::Usable([0.0, 0.0, rate_rad_s].into()));
        let lost = unread_turn(rate_rad_s, Reading::Missing);
        let clipped = unread_turn(rate_rad_s, Reading::Unusable);
        let turn = f64::from(rate_rad_s) * 0.01;
        assert!(read == 0.0 && lost < 0.1 * clipped + 1e-5, "{rate_rad_s}: {read} {lost} {clipped}");
        assert!((clipped / (turn * turn) - 1.0).abs() < 0.1, "{rate_rad_s}: {clipped}");
    }
}

/// Increments of samples at 100 Hz.
fn increments(
    samples: impl Iterator<Item = [Reading; 3]>,
    warming_k: impl Fn(usize) -> Option<f32>,
) -> Vec<Increment<f64>> {
    increments_at(10_000, samples, warming_k)
}

fn increments_at(
    period_us: u64,

    samples: impl Iterator<Item = [Reading; 3]>,
    warming_k: impl Fn(usize) -> Option<f32>,
) -> Vec<Increment<f64>> {
    let with = Composition::<f64>::new(&GyroModel::IDENTITY).unwrap();
    let mut builder = Builder::<f64>::zero();
    let period_s = period_us as f32 * 1e-6;
    builder.start(period_s, false);
    let taken = samples.enumerate().filter_map(|(k, readings)| {
        builder.warm(warming_k(k));
        match builder.push((period_us * k as u64, period_s), &with, readings) {
            Some(Item::Increment(increment)) => Some(increment),
            _ => None,
        }
    });
    taken.collect()
}

fn usable(v: [f32; 3]) -> Reading {
    Reading::Usable(v.into())
}

#[test]
fn a_force_beyond_the_full_scale_is_the_hardest_blow_and_leaves_the_velocity_uncertain() {
    let found = |hit: Reading| {
        let force = |k: usize| if k == 50 { hit } else { usable([0.0, 0.0, -9.8]) };
        let samples = (0..100).map(|k| [usable([0.0, 0.0, 0.1]), force(k), usable([20.0, 0.0, 40.0])]);
        let all = increments(samples, |_| None);
        let peak = all.iter().fold(0.0_f64, |most, increment| most.max(increment.peak));
        (peak, all.iter().map(|increment| increment.unread_velocity).sum::<f64>())
    };
    let (peak, unread) = found(Reading::Unusable);
    // 16 g for one period.
    assert!(peak > found(usable([0.0, 0.0, -400.0])).0 && (libm::sqrt(unread) - 1.57).abs() < 0.01, "{peak} {unread}");
    assert_eq!(found(Reading::Missing).1, 0.0);
}

#[test]
fn a_temperature_holds_until_the_next_one() {
    let samples = (0..100).map(|_| [usable([0.0, 0.0, 0.1]), usable([0.0, 0.0, -9.8]), usable([20.0, 0.0, 40.0])]);
    let warmed = increments(samples, |k| (k % 7 == 0).then_some(k as f32));
    assert!(warmed.len() > 20);
    for increment in warmed {
        let k = increment.end_us / 10_000;
        assert_eq!(increment.warming_k, Some((k - k % 7) as f64));
    }
}

#[test]
fn a_turn_that_is_bridged_is_less_than_half_a_turn() {
    // A string that slips at 300 rpm; one at 220 rpm, read 20 times a second.
    for (rate_rad_s, period_us, lost) in [(31.0, 10_000, 60..70), (23.0, 50_000, 60..62), (16.0, 50_000, 60..63)] {
        let rate = |k: usize| if lost.contains(&k) { Reading::Missing } else { usable([0.0, 0.0, rate_rad_s]) };
        let samples = (0..200).map(|k| [rate(k), usable([0.0, 0.0, -9.8]), usable([0.0, 0.0, 40.0])]);
        let all = increments_at(period_us, samples, |_| None);
        for increment in &all {
            assert!((increment.rate.z - f64::from(rate_rad_s)).abs() < 1e-3, "{increment:?}");
        }
        assert!(all.len() > 40);
    }
}

/// Largest force of all increments, with a blow at one sample, beside which the rates of some samples cannot be used.
#[test]
fn a_blow_beside_a_rate_that_cannot_be_used_is_seen() {
    for clipped in [50..51, 48..60] {
        let rate = |k: usize| if clipped.contains(&k) { Reading::Unusable } else { usable([0.0, 0.0, 0.1]) };
        let force = |k: usize| usable([if k == 50 { 100.0 } else { 0.0 }, 0.0, -9.8]);
        let all = increments((0..100).map(|k| [rate(k), force(k), usable([20.0, 0.0, 40.0])]), |_| None);
        let peak = all.iter().fold(0.0_f64, |most, increment| most.max(increment.peak));
        assert!((peak - 100.5).abs() < 0.1, "{peak}");
    }
}

#[test]
fn an_accelerometer_slower_than_the_samples_vibrates_as_much() {
    let vibration = |every: usize| {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(3);
        let mut force = || (f64::from(generator.next_u32()) / f64::from(u32::MAX) - 0.5) as f32 * 6.0;
        let samples = (0..4_000).map(|k| {
            let force = [force(), force(), force() - 9.8];
            let force = if k % every == 0 { usable(force) } else { Reading::Missing };
            [usable([0.0, 0.0, 0.1]), force, usable([20.0, 0.0, 40.0])]
        });
        let all = increments(samples, |_| None);
        all.iter().map(|increment| increment.vibration).sum::<f64>() / all.len() as f64
    };
    // The variance of 6 m/s^2, uniform.
    for every in [1, 2] {
        assert!((vibration(every) / 3.0 - 1.0).abs() < 0.1, "{every}: {}", vibration(every));
    }
}
