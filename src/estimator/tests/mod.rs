//! The filter on simulated motion by hand: what it recovers, and what it does not depend on.

extern crate std;

mod drilled;
mod field;
mod motion;
mod steps;
mod time;

use super::{Estimator, Posterior, Real, Refusal, Settings};
use crate::{
    compensation::{ActiveEffects, GyroModel},
    config::{Config, Motion},
    sample::Reading,
};
use motion::Simulated;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::{boxed::Box, vec::Vec};

fn settings() -> Settings {
    let mut config = Config { sample_period_us: 10_000, ..Config::default() };
    config.identification.motion = Motion::Hand;
    Settings::new(&config)
}

fn estimator<T: Real>() -> Box<Estimator<T>> {
    let mut estimator = Box::new(Estimator::zero());
    estimator.configure(&settings(), &[]);
    estimator
}

/// Posterior after a run of samples, the work done in pieces of `budget` units after each.
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
        estimator.push(*t_us, [*rate, *force, *field], None);
        done(&mut estimator, budget);
    }
    estimator.close(false);
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
        estimator.restore(stored, &[0.002; 12], &ActiveEffects::none());
        for (t_us, [rate, force, field]) in &simulated.samples {
            estimator.push(*t_us, [*rate, *force, *field], None);
            while estimator.step() > 0 {}
        }
        estimator.close(false);
        while estimator.step() > 0 {}
        let posterior = estimator.posterior().copied().unwrap();
        // The filter that is forgotten with its model is still the one that the posterior tells of.
        let [_, nis] = estimator.nis_of_claims();
        assert!((0.3..3.0).contains(&(nis / posterior.nis)), "{nis} beside {}", posterior.nis);
        (posterior.fitness, largest_difference(&posterior.gyro, &simulated.truth), estimator.filter.prior.is_restored)
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
    assert!(matches!(fitness(0), Err(Refusal::GyroUnusable { .. })), "{:?}", fitness(0));
    assert_eq!(fitness(1), Err(Refusal::NoAccelerometer));
    assert!(matches!(fitness(2), Err(Refusal::NoMagnetometer { .. })), "{:?}", fitness(2));
    let still: Vec<_> = samples.iter().take(900).copied().collect();
    assert!(matches!(posterior::<f32>(&still, u32::MAX).fitness, Err(Refusal::NotEnoughMotion { .. })));
}

/// In the frame of a known attitude: north, east, down.
fn to_ned() -> Matrix3<f64> {
    Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0)
}

#[test]
fn its_attitude_is_right_before_a_wrong_gyro_has_been_replaced() {
    let mut squares = Vec::new();
    for seed in 20..26 {
        let simulated = Simulated::new(seed, 40.0);
        let mut estimator = estimator::<f32>();
        let mut gyro_alone = simulated.attitudes[1_200];
        let samples = simulated.samples.iter().zip(&simulated.attitudes);
        for (index, ((t_us, [rate, force, field]), truth)) in samples.enumerate() {
            let can_look = estimator.push(*t_us, [*rate, *force, *field], None);
            if let (Reading::Usable(rate), 1_201..) = (rate, index) {
                gyro_alone *= Rotation3::from_scaled_axis(rate.cast::<f64>() * 0.01);
            }
            let is_asked = can_look && index >= 1_500 && index % 100 < 4;
            if is_asked {
                estimator.look();
            }
            while estimator.step() > 0 {}
            let Some(known) = estimator.known_attitude().filter(|_| is_asked) else { continue };
            let off = known.rotation.cast::<f64>() * (to_ned() * truth.matrix()).transpose();
            let error = Rotation3::from_matrix(&off).scaled_axis();
            let information = known.covariance.cast::<f64>().try_inverse().unwrap();
            squares.push(error.dot(&(information * error)) / 3.0);
            assert!(error.xy().norm() < 0.04, "seed {seed}, {index}: {error:?}");
        }
        let drift = (gyro_alone.inverse() * simulated.attitudes.last().unwrap()).angle();
        assert!(drift > 0.05, "seed {seed}: the gyro alone is no better, {drift} rad");
    }
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(squares.len() > 60 && mean < 3.0, "{mean} of {}", squares.len());
}

#[test]
fn before_it_is_aligned_it_has_no_attitude() {
    let mut estimator = estimator::<f32>();
    for (t_us, [rate, force, _]) in Simulated::new(1, 3.0).samples {
        if estimator.push(t_us, [rate, force, Reading::Missing], None) {
            estimator.look();
        }
        while estimator.step() > 0 {}
        assert!(estimator.known_attitude().is_none());
    }
}

/// Drives an estimator step by step, and hands out each step.
#[cfg(feature = "explanation")]
fn watched(samples: &[(u64, [Reading; 3])], mut watch: impl FnMut(&Estimator<f64>)) {
    let mut estimator = estimator::<f64>();
    for (index, (t_us, [rate, force, field])) in samples.iter().enumerate() {
        estimator.push(*t_us, [*rate, *force, *field], None);
        if index + 1 == samples.len() {
            estimator.close(false);
        }
        while estimator.step() > 0 {
            watch(&estimator);
        }
    }
}

#[cfg(feature = "explanation")]
#[test]
fn what_the_rows_moved_adds_up_to_what_the_filter_moved() {
    let simulated = Simulated::new(7, 30.0);
    let (mut sum, mut parts, mut last) = ([0.0_f64; 9], [0.0_f64; 4], [0.0_f64; 9]);
    watched(&simulated.samples, |estimator| {
        let settings = settings();
        for (k, last) in last.iter_mut().enumerate() {
            *last = estimator.filter.globals.x[super::columns::P.from + k]
                * f64::from(settings.sigma[super::columns::P.from + k]);
        }
        if let Some(moved) = estimator.moved_by_rows() {
            for (part, kind) in parts.iter_mut().zip([moved.field, moved.velocity, moved.position, moved.rest]) {
                sum.iter_mut().zip(kind).for_each(|(sum, x)| *sum += f64::from(x));
                *part += kind.iter().map(|x| f64::from(x.abs())).sum::<f64>();
            }
        }
    });
    let largest = last.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(largest > 0.02, "{largest}");
    for (sum, last) in sum.iter().zip(last) {
        assert!((sum - last).abs() < 1e-5, "{sum} {last}");
    }
    let [field, velocity, position, rest] = parts;
    assert!(field > 0.01 && velocity > 0.001 && position > 0.01 && rest < 0.2 * field, "{parts:?}");
}

/// Independent of the averaging itself: the evidence of all widths is their mean, so none can have less than its share.
#[cfg(feature = "explanation")]
#[test]
fn the_evidence_names_the_sensor_that_is_not_as_its_data_sheet_says() {
    let of = |shear: f32| {
        let bent = |reading: Reading| match reading {
            // No rotation of the earth's field, and no scale.
            Reading::Usable(v) => Reading::Usable(Vector3::new(v.x + shear * v.y, v.y, v.z - shear * v.x)),
            other => other,
        };
        let samples = Simulated::new(8, 60.0).samples;
        let samples: Vec<_> = samples.into_iter().map(|(t_us, [r, f, m])| (t_us, [r, f, bent(m)])).collect();
        let (mut found, mut widths) = (None, [0.0; 5]);
        watched(&samples, |estimator| {
            found = estimator.width_evidence().or(found);
            widths = estimator.posterior().map_or(widths, |posterior| posterior.widths);
        });
        (found.unwrap(), widths)
    };
    let ((sheet, _), (bad, widths)) = (of(0.03), of(0.2));
    let least = -libm::logf(3.0) - 1e-3;
    assert!(sheet.of_group.iter().chain(&bad.of_group).all(|x| *x > least), "{sheet:?} {bad:?}");
    assert!(sheet.of_group[0] < 0.5, "{sheet:?}");
    assert!(bad.of_group[0] > 5.0 && bad.all > 5.0 && widths[0] > 2.0, "{bad:?} {widths:?}");
}
