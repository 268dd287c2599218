//! The filter on simulated motion by hand: what it recovers, and what it does not depend on.

extern crate std;

mod motion;

use super::{Estimator, Posterior, Real, Settings, Unfit};
use crate::{
    compensation::GyroModel,
    config::{Config, Motion},
    sample::Reading,
};
use motion::Simulated;
use std::{boxed::Box, vec::Vec};

fn settings() -> Settings {
    let mut config = Config { sample_period_us: 10_000, ..Config::default() };
    config.identification.motion = Motion::Hand;
    Settings::new(&config)
}

fn estimator<T: Real>() -> Box<Estimator<T>> {
    let mut estimator = Box::new(Estimator::zero());
    estimator.configure(&settings());
    estimator
}

/// What an estimator says after a run of samples, its work done in pieces of `budget` units after each.
fn posterior<T: Real>(samples: &[(u64, [Reading; 3])], budget: u32) -> Posterior {
    let mut estimator = estimator::<T>();
    let done = |estimator: &mut Estimator<T>, budget: u32| {
        let mut spent = 0;
        while spent < budget {
            match estimator.step() {
                0 => break,
                units => spent += units,
            }
        }
    };
    for (t_us, [rate, force, field]) in samples {
        estimator.push(*t_us, *rate, *force, *field);
        done(&mut estimator, budget);
    }
    estimator.close();
    done(&mut estimator, u32::MAX);
    assert_eq!(estimator.lost(), 0);
    estimator.posterior().copied().unwrap()
}

fn largest_difference(a: &GyroModel, b: &GyroModel) -> f32 {
    let p = a.p.as_flattened().iter().zip(b.p.as_flattened());
    p.fold(0.0, |most, (a, b)| if (a - b).abs() > most { (a - b).abs() } else { most })
}

#[test]
fn a_gyro_that_is_off_by_percents_is_found_within_its_stated_deviations() {
    let mut squares = Vec::new();
    for seed in 0..6 {
        let simulated = Simulated::new(seed, 60.0);
        let found = posterior::<f32>(&simulated.samples, u32::MAX);
        assert_eq!(found.fitness, Ok(()), "seed {seed}");
        let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
        let after = largest_difference(&found.gyro, &simulated.truth);
        assert!(after < 0.25 * before, "seed {seed}: {after} of {before}");
        let truth = simulated.truth.p.as_flattened().iter().zip(found.gyro.p.as_flattened()).zip(&found.sigma);
        squares.extend(truth.map(|((truth, p), sigma)| ((truth - p) / sigma) * ((truth - p) / sigma)));
    }
    // Chi-square of 54 elements, correlated within a seed: under four where the covariance is honest or too large.
    let mean = squares.iter().sum::<f32>() / squares.len() as f32;
    assert!(mean < 4.0, "{mean}");
}

#[test]
fn a_stored_model_is_where_the_next_run_begins_unless_the_samples_contradict_it() {
    let simulated = Simulated::new(3, 60.0);
    let found = |stored: &GyroModel| {
        let mut estimator = estimator::<f32>();
        estimator.restore(stored, &[0.002; 12]);
        for (t_us, [rate, force, field]) in &simulated.samples {
            estimator.push(*t_us, *rate, *force, *field);
            while estimator.step() > 0 {}
        }
        estimator.close();
        while estimator.step() > 0 {}
        let posterior = estimator.posterior().copied().unwrap();
        (posterior.fitness, largest_difference(&posterior.gyro, &simulated.truth), estimator.is_restored)
    };
    let (fitness, off, is_restored) = found(&simulated.truth);
    assert!(fitness == Ok(()) && off < 0.002 && is_restored, "{fitness:?} {off}");
    let mut other = simulated.truth;
    other.p[0][0] += 0.3;
    let (fitness, _, is_restored) = found(&other);
    assert!(fitness != Ok(()) && !is_restored, "{fitness:?}");
}

#[test]
fn f32_loses_nothing_that_counts() {
    for seed in 0..3 {
        let samples = Simulated::new(seed, 60.0).samples;
        let (narrow, wide) = (posterior::<f32>(&samples, u32::MAX), posterior::<f64>(&samples, u32::MAX));
        let off = largest_difference(&narrow.gyro, &wide.gyro);
        assert!(off < 5e-4, "seed {seed}: {off}");
        assert_eq!(narrow.decided, wide.decided);
    }
}

#[test]
fn the_result_is_the_same_to_the_bit_however_the_work_is_sliced_and_whenever_time_begins() {
    let simulated = Simulated::new(4, 40.0);
    let whole = posterior::<f32>(&simulated.samples, u32::MAX);
    assert_eq!(posterior::<f32>(&simulated.samples, 150), whole);
    let later: Vec<_> = simulated.samples.iter().map(|(t_us, readings)| (t_us + 7_000_000_000, *readings)).collect();
    assert_eq!(posterior::<f32>(&later, u32::MAX), whole);
}

#[test]
fn a_gap_costs_what_it_spans() {
    let simulated = Simulated::new(5, 60.0);
    let without: Vec<_> =
        simulated.samples.iter().filter(|(t_us, _)| !(30_000_000..32_000_000).contains(t_us)).copied().collect();
    let (whole, cut) = (posterior::<f32>(&simulated.samples, u32::MAX), posterior::<f32>(&without, u32::MAX));
    assert!(
        cut.motion_s > whole.motion_s - 4.0 && cut.motion_s < whole.motion_s,
        "{} {}",
        cut.motion_s,
        whole.motion_s
    );
    let error = largest_difference(&cut.gyro, &simulated.truth);
    assert!(error < 0.3 * largest_difference(&GyroModel::IDENTITY, &simulated.truth), "{error}");
}

#[test]
fn without_a_sensor_nothing_flies_and_the_reason_is_told() {
    let samples = Simulated::new(6, 60.0).samples;
    let without = |sensor: usize| -> Vec<_> {
        let taken = |mut readings: [Reading; 3]| {
            if let Some(reading) = readings.get_mut(sensor) {
                *reading = Reading::Missing;
            }
            readings
        };
        samples.iter().map(|(t_us, readings)| (*t_us, taken(*readings))).collect()
    };
    let fitness = |sensor| posterior::<f32>(&without(sensor), u32::MAX).fitness;
    assert!(matches!(fitness(0), Err(Unfit::GyroUnusable { .. })), "{:?}", fitness(0));
    assert_eq!(fitness(1), Err(Unfit::NoAccelerometer));
    assert!(matches!(fitness(2), Err(Unfit::NoMagnetometer { .. })), "{:?}", fitness(2));
    let still: Vec<_> = samples.iter().take(900).copied().collect();
    assert!(matches!(posterior::<f32>(&still, u32::MAX).fitness, Err(Unfit::NotEnoughMotion { .. })));
}
