//! The filter on simulated motion by hand: what it recovers, and what it does not depend on.

extern crate std;

mod drilled;
mod motion;
mod steps;

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
fn a_few_lost_samples_cost_nothing_but_unusable_ones_do() {
    let simulated = Simulated::new(6, 60.0);
    let is_lost = |t_us: u64| t_us % 2_000_000 < 50_000;
    let lost: Vec<_> = simulated.samples.iter().filter(|(t_us, _)| !is_lost(*t_us)).copied().collect();
    let mut clipped = simulated.samples.clone();
    for (_, readings) in clipped.iter_mut().filter(|(t_us, _)| is_lost(*t_us)) {
        readings[0] = Reading::Unusable;
    }
    let [whole, lost, clipped] =
        [&simulated.samples, &lost, &clipped].map(|samples| posterior::<f32>(samples, u32::MAX));
    assert!((lost.motion_s - whole.motion_s).abs() < 0.5, "{} {}", lost.motion_s, whole.motion_s);
    let error = |found: &Posterior| largest_difference(&found.gyro, &simulated.truth);
    assert!(error(&lost) < 1.5 * error(&whole) + 0.002, "{} {}", error(&lost), error(&whole));
    // A rate beyond the full scale is not between its neighbours.
    assert!(clipped.motion_s < 0.8 * whole.motion_s, "{}", clipped.motion_s);
}

#[test]
fn a_clock_that_steps_is_no_turn() {
    for seed in 0..4 {
        let simulated = Simulated::new(seed, 60.0);
        // Every 3 s by 0.13 s, the first time before much is known.
        let steps = |t_us: u64| (t_us + 2_000_000) / 3_000_000 * 130_000;
        let samples: Vec<_> =
            simulated.samples.iter().map(|(t_us, readings)| (t_us + steps(*t_us), *readings)).collect();
        let error = largest_difference(&posterior::<f32>(&samples, u32::MAX).gyro, &simulated.truth);
        let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
        assert!(error < 0.4 * before, "seed {seed}: {error} of {before}");
    }
}

#[test]
fn gaps_for_half_of_the_time_are_not_the_gyros() {
    let simulated = Simulated::new(5, 120.0);
    let with_gaps: Vec<_> =
        simulated.samples.iter().filter(|(t_us, _)| t_us % 10_000_000 >= 5_500_000).copied().collect();
    let found = posterior::<f32>(&with_gaps, u32::MAX);
    assert_eq!(found.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    let after = largest_difference(&found.gyro, &simulated.truth);
    assert!(after < 0.5 * before, "{after} {before} {}", found.motion_s);
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

/// A magnetometer at 10 Hz is slower than the increments.
#[test]
fn a_slow_magnetometer_is_one() {
    let simulated = Simulated::new(6, 60.0);
    let mut samples = simulated.samples.clone();
    for (_, readings) in samples.iter_mut().enumerate().filter(|(k, _)| k % 10 != 0).map(|(_, sample)| sample) {
        readings[2] = Reading::Missing;
    }
    let found = posterior::<f32>(&samples, u32::MAX);
    assert_eq!(found.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    let error = largest_difference(&found.gyro, &simulated.truth);
    assert!(error < 0.4 * before, "{error} of {before}");
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

/// The samples with the field changed from one second to another, and back.
fn with_field(
    simulated: &Simulated,
    from_s: u64,
    to_s: u64,
    change: impl Fn(Vector3<f32>) -> Vector3<f32>,
) -> Posterior {
    let within = from_s * 1_000_000..to_s * 1_000_000;
    let changed = simulated.samples.iter().map(|(t_us, readings)| match readings {
        [rate, force, Reading::Usable(field)] if within.contains(t_us) => {
            (*t_us, [*rate, *force, Reading::Usable(change(*field))])
        }
        _ => (*t_us, *readings),
    });
    posterior::<f32>(&changed.collect::<Vec<_>>(), u32::MAX)
}

#[test]
fn a_field_that_is_turned_for_seconds_is_none() {
    for seed in 10..14 {
        let simulated = Simulated::new(seed, 60.0);
        let clean = largest_difference(&posterior::<f32>(&simulated.samples, u32::MAX).gyro, &simulated.truth);
        // Its norm stays.
        let hit =
            with_field(&simulated, 30, 34, |field| Rotation3::from_scaled_axis(Vector3::new(0.5, 0.0, 0.3)) * field);
        let error = largest_difference(&hit.gyro, &simulated.truth);
        assert_eq!(hit.fitness, Ok(()), "seed {seed}");
        assert!(error < 1.1 * clean + 1e-4, "seed {seed}: {error}, clean {clean}");
    }
}

#[test]
fn a_posterior_is_of_the_samples_up_to_its_request() {
    let simulated = Simulated::new(16, 30.0);
    let mut estimator = estimator::<f32>();
    let mut late = 0.0;
    for (k, (t_us, [rate, force, field])) in simulated.samples.iter().enumerate() {
        estimator.push(*t_us, [*rate, *force, *field], None);
        // Nothing is done between the two requests.
        if [2_000, 2_060].contains(&k) {
            estimator.close(false);
        }
        while !(2_000..2_060).contains(&k) && estimator.step() > 0 {
            if let Some(posterior) = estimator.posterior().filter(|_| k == 2_060 && late == 0.0) {
                late = posterior.motion_s;
            }
        }
    }
    let mut whole = Box::new(Estimator::<f32>::zero());
    whole.configure(&settings(), &[]);
    for (t_us, [rate, force, field]) in &simulated.samples[..=2_060] {
        whole.push(*t_us, [*rate, *force, *field], None);
        while whole.step() > 0 {}
    }
    whole.close(false);
    while whole.step() > 0 {}
    assert_eq!(late, whole.posterior().unwrap().motion_s);
}

/// By hand a field is judged by its usual norm.
#[test]
fn a_field_that_stays_weaker_is_the_usual_one_when_it_is_learnt_anew() {
    let simulated = Simulated::new(17, 140.0);
    let mut estimator = estimator::<f32>();
    for (t_us, [rate, force, field]) in &simulated.samples {
        let weaker = |field: &Vector3<f32>| Reading::Usable(field * if *t_us < 100_000_000 { 1.0 } else { 0.75 });
        let field = if let Reading::Usable(field) = field { weaker(field) } else { *field };
        estimator.push(*t_us, [*rate, *force, field], None);
        while estimator.step() > 0 {}
    }
    let usual = estimator.filter.node.norms.of_their_time();
    assert!((usual - 0.75).abs() < 0.03, "{usual} of the first field's norm");
}

#[test]
fn a_configuration_forgets_how_noisy_the_field_was() {
    let simulated = Simulated::new(18, 40.0);
    let mut estimator = estimator::<f32>();
    for (t_us, readings) in &simulated.samples {
        estimator.push(*t_us, *readings, None);
        while estimator.step() > 0 {}
    }
    assert!(estimator.filter.remainder.dispersion() > 0.0);
    estimator.configure(&settings(), &[]);
    assert_eq!(estimator.filter.remainder.dispersion(), 0.0);
}

#[test]
fn a_hard_iron_that_stays_another_is_learnt_anew() {
    let simulated = Simulated::new(15, 140.0);
    let other = with_field(&simulated, 60, 140, |field| field + Vector3::new(15.0, 0.0, -10.0));
    assert_eq!(other.fitness, Ok(()));
    let before = largest_difference(&GyroModel::IDENTITY, &simulated.truth);
    assert!(largest_difference(&other.gyro, &simulated.truth) < 0.25 * before);
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
