//! A shock that changes the gyro's bias: it is named with its time and its size, and the bias that flies follows it once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;

use meerkat_mwd::{
    Config,
    compensation::effects::LIBRARY,
    diagnosis::{DiagnosisReport, EffectReport},
};
use mwd::{
    configuration::of_trace,
    flight::{Flight, fly},
    simulate::{Scenario, simulate},
    trace::Trace,
};
use nalgebra::Vector3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

const SCENARIOS: [&str; 2] = ["drilling_45deg.toml", "drilling_vertical.toml"];

fn scenario(name: &str, change: impl Fn(&mut Scenario)) -> Scenario {
    let mut scenario =
        Scenario::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)).unwrap();
    change(&mut scenario);
    scenario.validate().unwrap();
    scenario
}

fn step_of(report: &DiagnosisReport) -> Option<EffectReport> {
    let is_step = |found: &&EffectReport| LIBRARY[usize::from(found.found.index)].name() == "gyro_bias_step";
    report.found().find(is_step).copied()
}

/// Root mean square of the seconds' mean errors of the rate that is put out, deg/s.
fn rate_error_deg_s(trace: &Trace, flight: &Flight, from_s: f64, to_s: f64) -> f64 {
    let rates = trace.true_rate.as_ref().unwrap();
    let errors: Vec<(f64, Vector3<f64>)> = trace
        .samples
        .iter()
        .zip(rates)
        .zip(&flight.outputs)
        .map(|((sample, truth), output)| {
            let truth: [f64; 3] = (*truth).map(|x| f64::from(x));
            let put_out = Vector3::from(output.rate_rad_s.map(f64::from));
            (sample.t_us as f64 * 1e-6, put_out - Vector3::from(truth))
        })
        .filter(|(t_s, _)| (from_s..to_s).contains(t_s))
        .collect();
    let seconds: Vec<f64> = errors
        .chunks(100)
        .map(|second| (second.iter().map(|(_, e)| e).sum::<Vector3<f64>>() / second.len() as f64).norm_squared())
        .collect();
    (seconds.iter().sum::<f64>() / seconds.len() as f64).sqrt().to_degrees()
}

#[test]
#[ignore]
fn measure() {
    let largest = std::env::var("PEAK").map_or([5.0, 20.0], |p| { let p: f64 = p.parse().unwrap(); [0.75 * p, p] });
    for name in SCENARIOS {
        let (mut named, mut n) = (0, 0);
        for seed in 0..std::env::var("SEEDS").map_or(10, |s| s.parse().unwrap()) {
            let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed ^ 0x57e9);
            let mut between =
                |low: f64, high: f64| low + (high - low) * f64::from(generator.next_u32()) / f64::from(u32::MAX);
            let length = between(0.2, 0.5);
            let step_deg_s = Vector3::from([(); 3].map(|()| between(-1.0, 1.0))).normalize() * length;
            let step_deg_s: [f64; 3] = step_deg_s.into();
            let after_s = between(36.0, 70.0);
            let scenario = scenario(name, |s| {
                s.duration_s = 170.0;
                s.effects.bias_step_deg_s = step_deg_s;
                s.effects.bias_step_after_s = after_s;
                s.shocks.peak_g = largest;
            });
            let (trace, truth) = simulate(&scenario, seed);
            let at_s = truth.shocks.iter().map(|s| s.start_s).find(|t| *t >= after_s).unwrap();
            let shock = truth.shocks.iter().find(|s| s.start_s >= after_s).unwrap();
            let config = of_trace(&trace);
            let flight = fly(&config, &trace.samples, |_| {}).unwrap();
            let off = fly(&Config { effects: false, ..config }, &trace.samples, |_| {}).unwrap();
            n += 1;
            let expected = truth.gyro.p_matrix().cast::<f64>() * Vector3::from(step_deg_s);
            print!("{name} seed {seed:2} step {length:.2} at {at_s:6.2} ({:4.1} g ms) ", Vector3::from(shock.peak_m_s2).norm() / 9.8 * shock.length_s * 1e3);
            for report in &flight.diagnoses {
                let names: Vec<_> = report.found().map(|f| LIBRARY[usize::from(f.found.index)].name()).collect();
                if let Some(found) = step_of(report) {
                    named += 1;
                    let t_s = report.bias_step.unwrap().t_us as f64 * 1e-6;
                    let z = [0, 1, 2].map(|k| {
                        (f64::from(found.found.parameters[k]).to_degrees() - expected[k]) / f64::from(found.found.sigma[k]).to_degrees()
                    });
                    print!("| found {t_s:6.2} p {:.0e} gain {:.0} z {:.1?} sigma {:.3?} ", found.p_value, found.evidence, z, found.found.sigma.map(f32::to_degrees)[0]);
                } else {
                    print!("| {names:?} {:?} ", report.tried[14].p_value);
                }
            }
            let landing_s = if at_s < 72.0 { 82.0 } else { 118.0 };
            println!(
                "| error {:.3} off {:.3}; late {:.3} off {:.3}",
                rate_error_deg_s(&trace, &flight, landing_s, landing_s + 50.0),
                rate_error_deg_s(&trace, &off, landing_s, landing_s + 50.0),
                rate_error_deg_s(&trace, &flight, 150.0, 170.0),
                rate_error_deg_s(&trace, &off, 150.0, 170.0),
            );
        }
        println!("{name}: {named} of {n}");
    }
}

#[test]
#[ignore]
fn clean() {
    for name in SCENARIOS {
        let (mut diagnoses, mut false_alarms) = (0, 0);
        for seed in 100..std::env::var("SEEDS").map_or(110, |s| 100 + s.parse::<u64>().unwrap()) {
            let (trace, _) = simulate(&scenario(name, |_| {}), seed);
            let flight = fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap();
            for report in &flight.diagnoses {
                diagnoses += 1;
                if let Some(found) = step_of(report) {
                    false_alarms += 1;
                    println!("{name} seed {seed} at {:?} p {:.1e} {:?}", report.bias_step.unwrap().t_us, found.p_value, found.found.parameters.map(f32::to_degrees));
                }
            }
        }
        println!("{name}: {false_alarms} of {diagnoses}");
    }
}
