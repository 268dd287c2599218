//! A probe that continues where it ended: benefit of a stored filter for the next run, beside the stored
//! model alone and beside nothing.

use super::flight::probe;
use crate::rig::files::{FAST_ROTATION, recording, scenario};
use meerkat_mwd::{
    Config, Probe,
    compensation::GyroModel,
    estimator::{LearntHead, NUMBERS},
    identification::Decision,
    storage::{StoreReason, StoredModel, fingerprint},
};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use testbed::{
    flight::configuration::of_trace,
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, known_error, simulate},
    trace::Trace,
};

/// Times at which the second run is looked at, seconds; it moves from 10 s on.
const AT_S: [u64; 3] = [20, 35, 50];
/// Two and a half minutes of the first run.
const LONG_S: f64 = 150.0;

/// Model and filter that a first run leaves behind.
struct Ended {
    model: StoredModel,
    head: LearntHead,
    numbers: Vec<f32>,
}

/// Stored state that a second run starts with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum With {
    Nothing,
    Model,
    ModelAndFilter,
}

const ALL: [With; 3] = [With::Nothing, With::Model, With::ModelAndFilter];

/// Flies a run; returns the deviations of the last accepted model.
fn fly(probe: &mut Probe, trace: &Trace, mut each: impl FnMut(u64, &Probe)) -> [f32; 12] {
    let mut sigma = [0.0; 12];
    for sample in &trace.samples {
        probe.push(sample);
        if let Some(report) = probe.poll(probe.poll_budget()).filter(|report| report.decision == Decision::Accepted) {
            sigma = report.sigma;
        }
        while probe.take_diagnosis().is_some() {}
        each(sample.t_us - trace.first_us(), probe);
    }
    sigma
}

fn ended(config: &Config, trace: &Trace) -> Ended {
    let mut first = probe(config, None);
    let sigma = fly(&mut first, trace, |_, _| {});
    while first.learnt().is_none() {
        first.poll(1);
    }
    let learnt = first.learnt().unwrap();
    Ended {
        model: StoredModel {
            gyro: *first.gyro_model(),
            sigma,
            effects: *first.effects(),
            library: fingerprint(first.library(), config),
            temperature_c: None,
            t_us: 1,
            reason: StoreReason::Command,
        },
        head: learnt.head,
        numbers: (0..NUMBERS).map(|k| learnt.number(k)).collect(),
    }
}

fn begun(config: &Config, ended: &Ended, with: With) -> Box<Probe> {
    let mut probe = probe(config, (with != With::Nothing).then_some(&ended.model));
    if with == With::ModelAndFilter {
        let read = |take: &mut dyn FnMut(usize, f32)| {
            ended.numbers.iter().enumerate().for_each(|(k, x)| take(k, *x));
            true
        };
        assert_eq!(probe.go_on(&ended.head, read), Ok(()));
    }
    probe
}

/// Models that fly at each of those times.
fn flown(mut probe: Box<Probe>, trace: &Trace) -> [GyroModel; AT_S.len()] {
    let mut flown = [GyroModel::IDENTITY; AT_S.len()];
    fly(&mut probe, trace, |t_us, probe| {
        for (at_s, flown) in AT_S.iter().zip(&mut flown) {
            if t_us <= at_s * 1_000_000 {
                *flown = *probe.gyro_model();
            }
        }
    });
    flown
}

/// Medians and the worst of a column.
fn summary(errors: &[[f64; AT_S.len()]], k: usize) -> [f64; 2] {
    let mut column: Vec<f64> = errors.iter().map(|errors| errors[k]).collect();
    column.sort_by(f64::total_cmp);
    [column[column.len() / 2], column[column.len() - 1]]
}

fn print(what: &str, tables: &[Vec<[f64; AT_S.len()]>; 3]) {
    println!("{what}, median [worst] of {}, {AT_S:?} s after the start:", tables[0].len());
    for (with, errors) in ALL.iter().zip(tables) {
        let cells =
            (0..AT_S.len()).map(|k| summary(errors, k)).map(|[median, worst]| format!("{median:.3} [{worst:.3}]"));
        println!("| {with:?} | {} |", cells.collect::<Vec<_>>().join(" | "));
    }
}

/// Normal, near enough.
fn normal(generator: &mut Xoshiro128PlusPlus) -> f64 {
    (0..12).map(|_| f64::from(generator.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0
}

/// Rate errors of the second run, deg/s, where each element of P has changed by `shock` (1 sigma) in between;
/// the bias is always another one, and so is the hard iron where `errs` has the vector sensors err by what
/// data sheets allow. `moves_otherwise`: in another hole, thrice as fast.
fn drilled(shock: f64, errs: bool, moves_otherwise: bool) -> [Vec<[f64; AT_S.len()]>; 3] {
    let mut tables = [const { Vec::new() }; 3];
    for seed in 0..12 {
        let mut first = Scenario { duration_s: LONG_S, ..scenario("drilling_45deg") };
        let mut dice = Xoshiro128PlusPlus::seed_from_u64(seed);
        if errs {
            let effects = &mut first.effects;
            effects.accel_matrix.as_flattened_mut().iter_mut().for_each(|x| *x = 0.005 * normal(&mut dice));
            // Antisymmetric part, left out: it would turn the frame in which P is known.
            let m = effects.accel_matrix;
            effects.accel_matrix = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (m[i][j] + m[j][i])));
            effects.mag_matrix.as_flattened_mut().iter_mut().for_each(|x| *x = 0.01 * normal(&mut dice));
            effects.accel_bias_m_s2 = [(); 3].map(|()| 0.02 * normal(&mut dice));
            effects.hard_iron_ut = [(); 3].map(|()| 0.5 * normal(&mut dice));
        }
        let (trace, truth) = simulate(&first, seed);
        let config = of_trace(&trace);
        let ended = ended(&config, &trace);
        let mut second = first.clone();
        let p = truth.gyro.p.map(|row| row.map(|x| f64::from(x) + shock * normal(&mut dice)));
        second.gyro.p = Some(p);
        if errs {
            second.effects.hard_iron_ut = [(); 3].map(|()| 0.5 * normal(&mut dice));
        }
        if moves_otherwise {
            second.hole.inclination_deg = 20.0;
            (second.rotation.mean_rpm, second.rotation.stick_slip) = (90.0, 0.3);
        }
        second.duration_s = 52.0;
        let (trace, truth) = simulate(&second, 1_000 + seed);
        let rates = &trace.true_rate.as_ref().unwrap()[1_300..];
        for (with, table) in ALL.into_iter().zip(&mut tables) {
            let flown = flown(begun(&config, &ended, with), &trace);
            table.push(std::array::from_fn(|k| {
                let at = truth.gyro_at(AT_S[k] as usize * 100);
                systematic_rate_error_rad_s(&at, &flown[k], rates).unwrap().to_degrees()
            }));
        }
    }
    tables
}

/// Returns true if the median is no worse than from the factory's prior, by more than chance makes of so few seeds:
/// that of twelve errs by a seventh where they scatter by two fifths. The worst seed may be: see what is printed.
fn is_no_worse([nothing, _, filter]: &[Vec<[f64; AT_S.len()]>; 3], k: usize) -> bool {
    summary(filter, k)[0] <= 1.15 * summary(nothing, k)[0]
}

#[test]
fn a_probe_in_a_drill_string_starts_where_it_ended() {
    for (what, errs, moves_otherwise) in [
        ("Drilling", false, false),
        ("Vector sensors that err", true, false),
        ("Then 90 rpm at 20 deg", false, true),
        ("Vector sensors that err, then 90 rpm at 20 deg", true, true),
    ] {
        let tables = drilled(0.0, errs, moves_otherwise);
        print(&format!("{what}, deg/s"), &tables);
        for k in 0..AT_S.len() {
            assert!(is_no_worse(&tables, k), "{what}, {k}");
        }
        // Ten seconds of motion after the start it is better than after forty from the factory's prior; where vector
        // sensors err no worse, by more than chance: these errors are what is left of both (0.424 and 0.418 deg/s of
        // sixty seeds).
        let most = if errs && !moves_otherwise { 1.15 } else { 1.0 };
        assert!(summary(&tables[2], 0)[0] < most * summary(&tables[0], 2)[0], "{what}");
    }
}

/// As after a fall: what was stored is of another gyro.
#[test]
fn a_gyro_that_has_changed_by_a_percent_in_between_is_found_again() {
    for (what, errs, moves_otherwise) in [
        ("P changed by 1 %", false, false),
        ("P changed, vector sensors that err", true, false),
        ("P changed, then 90 rpm at 20 deg", false, true),
        ("P changed, vector sensors that err, then 90 rpm at 20 deg", true, true),
    ] {
        let tables = drilled(0.01, errs, moves_otherwise);
        print(&format!("{what}, deg/s"), &tables);
        // Ten seconds after the start of motion the stored P, which is off by 1.9 deg/s, has been left: the data
        // exclude it. Where vector sensors err, what was learnt of these says so sooner than the model alone: 0.6 of
        // its error is left of sixty seeds; the medians of twelve err by a seventh each.
        let [model, filter] = [1, 2].map(|with| summary(&tables[with], 0)[0]);
        assert!(filter < 0.3 || filter < 0.75 * model, "{what}: {model} {filter}");
        for k in 0..AT_S.len() {
            // Not where sensors err: what of P's change looks like their errors is held against what the
            // first run said of these (0.76 deg/s at 50 s, 0.57 from the factory's prior).
            assert!(is_no_worse(&tables, k) || errs && !moves_otherwise, "{what}, {k}");
        }
    }
}

/// The same recording twice, with another error multiplied in each time.
#[test]
fn a_recorded_sensor_starts_where_it_ended() {
    let recorded = recording(FAST_ROTATION);
    for changed in [0.0, 0.01] {
        let mut tables = [const { Vec::new() }; 3];
        for seed in 0..10 {
            let mut dice = Xoshiro128PlusPlus::seed_from_u64(seed);
            let drawn = |dice: &mut Xoshiro128PlusPlus, about: &GyroModel, size: f64| GyroModel {
                p: about.p.map(|row| row.map(|x| x + (size * normal(dice)) as f32)),
                b_rad_s: [(); 3].map(|()| (0.01 * normal(dice)) as f32),
            };
            let first = drawn(&mut dice, &GyroModel::IDENTITY, 0.03);
            let second = drawn(&mut dice, &first, changed);
            let with = |error: &GyroModel| {
                let mut trace = recorded.clone();
                known_error::apply(&mut trace, error);
                trace
            };
            let config = of_trace(&recorded);
            let ended = ended(&config, &with(&first));
            let trace = with(&second);
            for (with, table) in ALL.into_iter().zip(&mut tables) {
                let flown = flown(begun(&config, &ended, with), &trace);
                table.push(flown.map(|flown| {
                    let off = flown.p.as_flattened().iter().zip(second.p.as_flattened());
                    100.0 * (off.map(|(p, truth)| f64::from(p - truth).powi(2)).sum::<f64>() / 9.0).sqrt()
                }));
            }
        }
        print(&format!("Recording, P changed by {} %: rms error of P, %", 100.0 * changed), &tables);
        for k in 0..AT_S.len() {
            assert!(is_no_worse(&tables, k), "{changed}, {k}");
        }
    }
}
