//! Simulated drilling with known truth, drawn off-centre at random: what one 50 s window is worth on the six
//! minutes after it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;

use meerkat_mwd::{
    Config,
    compensation::GyroModel,
    config::OptimizerKind,
    identification::{Decision, WindowReport},
};
use testbed::{
    flight::{Flight, configuration::of_trace, fly, fly_frozen},
    score::systematic_rate_error_rad_s,
    simulate::{Scenario, Truth, simulate},
    trace::Trace,
};

use rig::files::scenario;

const SEEDS: u64 = 20;
/// One window: 10 s at rest, then drilling.
const WINDOW_END_S: f64 = 50.0;

/// Flies a run, frozen as soon as the result of the first window has taken effect.
fn frozen_after_one_window(trace: &Trace, config: &Config) -> Flight {
    let latency_us = (config.identification.latency_s * 1e6) as u64;
    fly_frozen(config, trace.first_us() + (WINDOW_END_S * 1e6) as u64 + latency_us, &trace.samples).unwrap()
}

fn flown_model(flight: &Flight) -> (GyroModel, WindowReport) {
    assert_eq!(flight.reports.len(), 1);
    let report = *flight.reports.last().expect("a window");
    (report.flown, report)
}

/// Systematic rate errors over the six minutes after the freeze, deg/s: of the raw gyro, of the factory's P
/// with the window's bias, and of what is flown.
fn rate_errors(trace: &Trace, truth: &Truth, flight: &Flight) -> [f64; 3] {
    let from = trace.samples.partition_point(|s| s.t_us < flight.frozen_at_us.unwrap());
    let rates = &trace.true_rate.as_ref().unwrap()[from..];
    let (flown, report) = flown_model(flight);
    [GyroModel::IDENTITY, report.bias_only, flown]
        .map(|model| systematic_rate_error_rad_s(&truth.gyro, &model, rates).unwrap().to_degrees())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Raw is several deg/s; after one window the median of 20 seeds is under `most_deg_s` (the Cramer-Rao bound
/// of such a window, for sensors without errors of their own, is 0.015 to 0.025), and no seed is worse off
/// than with bias only.
fn one_window_is_enough(name: &str, most_deg_s: f64) {
    let scenario = scenario(name);
    let mut errors = Vec::new();
    for seed in 0..SEEDS {
        let (trace, truth) = simulate(&scenario, seed);
        let flight = frozen_after_one_window(&trace, &of_trace(&trace));
        let [raw, bias_only, flown] = rate_errors(&trace, &truth, &flight);
        let (_, report) = flown_model(&flight);
        println!(
            "{name} seed {seed:2}: raw {raw:6.3}  bias only {bias_only:6.3}  flown {flown:6.3} deg/s  {:?}",
            report.decision
        );
        assert!(flown <= 1.05 * bias_only, "seed {seed}: worse than bias only");
        errors.push([raw, bias_only, flown]);
    }
    let [raw, bias_only, flown] = [0, 1, 2].map(|k| {
        let values: Vec<f64> = errors.iter().map(|e| e[k]).collect();
        let worst = values.iter().copied().fold(0.0, f64::max);
        (median(values), worst)
    });
    let cell = |(median, worst): (f64, f64)| format!("{median:.3} [{worst:.3}]");
    println!("{name}, deg/s, median [worst] of {SEEDS} seeds:");
    println!("| raw | bias only | flown |\n| {} | {} | {} |", cell(raw), cell(bias_only), cell(flown));
    let (raw, flown) = (raw.0, flown.0);
    assert!(raw > 2.0);
    assert!(flown < most_deg_s);
}

#[test]
fn one_window_of_vertical_drilling_is_enough() {
    one_window_is_enough("drilling_vertical", 0.045);
}

#[test]
fn one_window_of_drilling_at_45_deg_is_enough() {
    one_window_is_enough("drilling_45deg", 0.035);
}

/// The search's own promise: within 1 % of the Levenberg-Marquardt optimum of the same cost in the
/// evaluations that it is given, from every seed.
#[test]
fn imoa_reaches_the_optimum_of_levenberg_marquardt_in_the_evaluations_that_it_is_given() {
    let scenario = Scenario { duration_s: 56.0, ..scenario("drilling_45deg") };
    let (trace, _) = simulate(&scenario, 100);
    let cost = |optimizer: OptimizerKind, seed: u64| {
        let mut config = of_trace(&trace);
        config.identification.optimizer = optimizer;
        config.seed = seed;
        let flight = frozen_after_one_window(&trace, &config);
        let (_, report) = flown_model(&flight);
        assert!(report.evaluations <= config.identification.max_evaluations, "{}", report.evaluations);
        assert_eq!(report.decision, Decision::Accepted);
        f64::from(report.cost_after.unwrap())
    };
    let optimum = cost(OptimizerKind::Lm, 0);
    let start = cost(OptimizerKind::Ls, 0);
    println!("least squares {start:.3}, Levenberg-Marquardt {optimum:.3}");
    for seed in 0..SEEDS {
        let found = cost(OptimizerKind::Imoa, seed);
        println!("seed {seed:2}: {found:.3}");
        assert!(found < 1.01 * optimum, "seed {seed}: {found} against {optimum}");
    }
}

/// A shock can change the gyro for good. The windows after it contradict what the ones before it taught, and
/// outweigh it within minutes: three quarters of the change at least, since the filter forgets over some
/// three minutes.
#[test]
fn a_gyro_that_changes_for_good_is_identified_anew() {
    const CHANGE_S: f64 = 120.0;
    let scale = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.03, 0.98, 1.02_f32));
    for seed in 0..3 {
        let (mut trace, truth) = simulate(&Scenario { duration_s: 330.0, ..scenario("drilling_45deg") }, seed);
        let changed = trace.samples.partition_point(|s| s.t_us < trace.first_us() + (CHANGE_S * 1e6) as u64);
        for sample in &mut trace.samples[changed..] {
            sample.gyro_rad_s = (scale * nalgebra::Vector3::from(sample.gyro_rad_s)).into();
        }
        let p = truth.gyro.p_matrix() * scale.try_inverse().unwrap();
        let b_rad_s = (scale * nalgebra::Vector3::from(truth.gyro.b_rad_s)).into();
        let new = GyroModel { p: std::array::from_fn(|i| std::array::from_fn(|j| p[(i, j)])), b_rad_s };

        let flight = fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap();
        let rates = &trace.true_rate.as_ref().unwrap()[changed..];
        let error = |model: &GyroModel| systematic_rate_error_rad_s(&new, model, rates).unwrap().to_degrees();
        let before = flight.reports.iter().rfind(|r| r.t_end_us <= trace.samples[changed].t_us).unwrap();
        let last = flight.reports.last().unwrap();
        println!(
            "seed {seed}: {:.3} deg/s with the old model, {:.3} at the end",
            error(&before.flown),
            error(&last.flown)
        );
        assert!(
            error(&before.flown) > 1.0 && error(&last.flown) < 0.25 * error(&before.flown),
            "seed {seed}: {:?}",
            flight.reports
        );
    }
}

/// The filter forgets little, so that in half an hour it comes to know for good what a node's rows tell in error: a
/// turn of the axes of all sensors together, which no reading shows, seemed known in more than half of such runs, and P
/// was wrong by 1 deg/s and more.
#[test]
fn after_forty_minutes_of_a_vertical_hole_the_model_is_better_than_after_a_window() {
    let scenario = Scenario { duration_s: 2_461.0, ..scenario("drilling_vertical") };
    let errors: Vec<[f64; 2]> = (0..4)
        .map(|seed| {
            let (trace, truth) = simulate(&scenario, seed);
            let config = Config { effects: false, ..of_trace(&trace) };
            let reports = fly(&config, &trace.samples, |_| {}).unwrap().reports;
            [55, 2_400].map(|at_s| {
                let from = at_s * 100;
                let t_us = trace.samples[from].t_us;
                let landed = reports.iter().rfind(|report| report.t_effect_us.is_some_and(|effect| effect <= t_us));
                let rates = &trace.true_rate.as_ref().unwrap()[from..from + 6_000];
                let flown = landed.expect("a window").flown;
                systematic_rate_error_rad_s(&truth.gyro_at(from), &flown, rates).unwrap().to_degrees()
            })
        })
        .collect();
    println!("deg/s after the first window and after forty minutes: {errors:.3?}");
    for (seed, [first, last]) in errors.iter().enumerate() {
        assert!(last < first, "seed {seed}: {first} {last}");
    }
}
