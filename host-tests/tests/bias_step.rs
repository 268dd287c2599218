//! A shock that changes the gyro's bias is named with time and size, and the flown bias follows it once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;

use meerkat_mwd::{
    Config,
    diagnosis::{DiagnosisReport, EffectReport},
};
use nalgebra::Vector3;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use testbed::{
    flight::{Flight, configuration::of_trace, fly},
    simulate::{Scenario, simulate},
    trace::Trace,
};

use rig::files;

/// Specific force from which a shock stands out of the vibration, whose half seconds reach 15 to 25 m/s^2.
const STANDS_OUT_M_S2: f32 = 60.0;

const SCENARIOS: [&str; 2] = ["drilling_45deg", "drilling_vertical"];

fn scenario(name: &str, change: impl Fn(&mut Scenario)) -> Scenario {
    let mut scenario = files::scenario(name);
    change(&mut scenario);
    scenario.validate().unwrap();
    scenario
}

fn steps_of(report: &DiagnosisReport) -> impl Iterator<Item = EffectReport> + '_ {
    report.found().filter(|found| found.step_us > 0).copied()
}

/// Largest specific force read within a tenth of a second.
fn hardest_m_s2(trace: &Trace, from_s: f64) -> f32 {
    let within = trace.samples.iter().filter(|s| (from_s..from_s + 0.1).contains(&(s.t_us as f64 * 1e-6)));
    within
        .map(|sample| Vector3::from(sample.accel_m_s2).norm())
        .fold(0.0, |most: f32, x| if x > most { x } else { most })
}

/// Rms over seconds of the mean error of the output rate, deg/s.
fn rate_error_deg_s(trace: &Trace, flight: &Flight, from_s: f64, to_s: f64) -> f64 {
    let rates = trace.true_rate.as_ref().unwrap();
    let errors: Vec<(f64, Vector3<f64>)> = trace
        .samples
        .iter()
        .zip(rates)
        .zip(&flight.outputs)
        .map(|((sample, truth), output)| {
            let truth: [f64; 3] = (*truth).map(f64::from);
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

/// Steps of 0.2 to 0.5 deg/s at hard shocks. A shock between two samples does not stand out of the vibration:
/// its step is dated to the next one that does. A shock that stands out is dated right, and no other is named
/// beside it.
#[test]
fn a_step_at_a_shock_is_named_with_its_time_and_size_and_followed() {
    const SEEDS: u64 = 12;
    let (mut within, mut components) = (0, 0);
    for name in SCENARIOS {
        let (mut named, mut misdated, mut missed_though_hard, mut followed, mut better) = (0, 0, 0_u32, 0, 0);
        for seed in 0..SEEDS {
            let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed ^ 0x57e9);
            let mut between =
                |low: f64, high: f64| low + (high - low) * f64::from(generator.next_u32()) / f64::from(u32::MAX);
            let length_deg_s = between(0.2, 0.5);
            let direction = Vector3::from([(); 3].map(|()| between(-1.0, 1.0))).normalize();
            let (step_deg_s, after_s) = (direction * length_deg_s, between(36.0, 70.0));
            let scenario = scenario(name, |scenario| {
                scenario.duration_s = 170.0;
                scenario.effects.bias_step_deg_s = step_deg_s.into();
                scenario.effects.bias_step_after_s = after_s;
                scenario.shocks.peak_g = [15.0, 20.0];
            });
            let (trace, truth) = simulate(&scenario, seed);
            let at_s = truth.shocks.iter().map(|shock| shock.start_s).find(|start_s| *start_s >= after_s).unwrap();
            let config = of_trace(&trace);
            let flight = fly(&config, &trace.samples, |_| {}).unwrap();
            // A shock and its ringing are one for 2 s.
            let is_it = |step: &EffectReport| (step.step_us as f64 * 1e-6 - at_s).abs() < 2.0;
            let (told, others): (Vec<EffectReport>, Vec<EffectReport>) =
                flight.diagnoses.iter().flat_map(steps_of).partition(is_it);
            let mut others_s: Vec<f64> = others.iter().map(|step| step.step_us as f64 * 1e-6).collect();
            others_s.dedup();
            let (Some(first), Some(last)) = (told.first(), told.last()) else {
                let hardest = hardest_m_s2(&trace, at_s);
                println!(
                    "{name} seed {seed:2}: {length_deg_s:.2} deg/s at {at_s:.1}, hardest {hardest:.0} m/s^2: not found; told {others_s:?}"
                );
                // The next shock that stands out is taken for it.
                misdated += u32::from(!others_s.is_empty());
                missed_though_hard += u32::from(hardest > STANDS_OUT_M_S2 && !others_s.is_empty());
                continue;
            };
            named += 1;
            assert!(others_s.is_empty(), "{name} {seed}: {at_s:.1}, and also {others_s:?}");
            assert!(
                told.iter().all(|step| step.step_us == first.step_us),
                "{name} {seed}: one step, one time: {told:?}"
            );
            let expected = truth.gyro.p_matrix().cast::<f64>() * step_deg_s;
            for k in 0..3 {
                let [size, sigma] = [last.found.parameters[k], last.found.sigma[k]].map(|x| f64::from(x).to_degrees());
                within += u32::from((size - expected[k]).abs() < 3.0 * sigma);
                components += 1;
                // Limit that one of 72 Gaussian components exceeds in one of 2,000 runs of this test.
                assert!(
                    (size - expected[k]).abs() < 4.5 * sigma,
                    "{name} {seed}: {size} for {} +- {sigma}",
                    expected[k]
                );
            }
            let off = fly(&Config { effects: false, ..config }, &trace.samples, |_| {}).unwrap();
            let from_s = first.taken_out_us as f64 * 1e-6;
            let [on, off] = [&flight, &off].map(|flight| rate_error_deg_s(&trace, flight, from_s, from_s + 60.0));
            println!(
                "{name} seed {seed:2}: {length_deg_s:.2} deg/s at {at_s:.1}, of {:.1} by {:.1}, evidence {:.0}, taken out from {from_s:.1}; \
                 rate error {on:.3}, without {off:.3} deg/s",
                first.step_us as f64 * 1e-6,
                first.found_us as f64 * 1e-6,
                first.evidence
            );
            assert!(first.is_taken_out() && first.found_us <= first.taken_out_us, "{name} {seed}: {first:?}");
            followed += u32::from(from_s < at_s + 30.0);
            better += u32::from(on < off);
            // The model keeps the new bias: no jump back.
            let model = flight.reports.last().unwrap().flown;
            let new = Vector3::from(*truth.bias_rad_s.last().unwrap());
            let error = (Vector3::from(model.b_rad_s) - new).map(|x| f64::from(x).to_degrees());
            assert!(error.norm() < 0.7 * length_deg_s, "{name} {seed}: {error}");
        }
        println!(
            "{name}: {named} of {SEEDS} named, {misdated} at another time, {followed} followed within half a minute, {better} better"
        );
        // Three places for twenty shocks a minute: one in ten is seen and finds no place.
        assert!(missed_though_hard <= 1, "{name}: {missed_though_hard} hard shocks found no place");
        // A shock of some milliseconds may fall between two samples: a third of them hardly shows, and
        // another is taken for it.
        assert!(named >= 6 && named + misdated >= 10, "{name}: {named} of {SEEDS} named, {misdated} at another time");
        assert!(4 * followed >= 3 * named, "{name}: {followed} followed of {named}");
        assert!(4 * better >= 3 * named, "{name}: better in {better} of {named}");
    }
    println!("{within} of {components} components within 3 sigma");
    assert!(100 * within >= 95 * components, "{within} of {components}");
}

/// Noise alone reaches a Bayes factor of e^5 times the number of shocks in at most one run in 150 (Ville);
/// three or more of 20 runs do so once in 3,000 times.
#[test]
fn shocks_without_a_step_are_not_taken_for_one() {
    let mut false_alarms = 0;
    for name in SCENARIOS {
        for seed in 100..110 {
            let (trace, truth) = simulate(&scenario(name, |_| {}), seed);
            assert!(!truth.shocks.is_empty(), "{name} {seed}");
            let flight = fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap();
            assert!(flight.diagnoses.len() > 5, "{name} {seed}");
            let told: Vec<EffectReport> = flight.diagnoses.iter().flat_map(steps_of).collect();
            if let Some(step) = told.first() {
                println!("{name} seed {seed}: {step:?}");
            }
            false_alarms += usize::from(!told.is_empty());
        }
    }
    assert!(false_alarms <= 2, "{false_alarms} of 20 runs");
}

/// A step of the bias while nothing hits the tool has another cause.
#[test]
fn a_step_without_a_shock_is_not_named() {
    for seed in 0..3 {
        let calm = scenario("drilling_45deg", |scenario| {
            scenario.duration_s = 125.0;
            scenario.effects.bias_step_deg_s = [0.3, -0.2, 0.3];
            scenario.effects.bias_step_after_s = 55.0;
            scenario.shocks.per_minute = 0.0;
        });
        let trace = simulate(&calm, seed).0;
        let flight = fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap();
        assert_eq!(flight.diagnoses.iter().flat_map(steps_of).count(), 0, "{seed}");
    }
}

/// Two steps in one run, each at a shock that stands out: each is named with its own time, and both are in
/// the flown bias. Shocks are rare enough for the three places that steps are looked for in at a time.
#[test]
fn a_second_step_is_told_from_the_first() {
    let (mut both, mut runs, mut others) = (0, 0, 0);
    for seed in 0..10 {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed ^ 0x25e9);
        let mut between =
            |low: f64, high: f64| low + (high - low) * f64::from(generator.next_u32()) / f64::from(u32::MAX);
        let mut draw = || {
            let direction = Vector3::from([(); 3].map(|()| between(-1.0, 1.0))).normalize();
            direction * between(0.25, 0.5)
        };
        let steps_deg_s = [draw(), draw()];
        let scenario = scenario("drilling_45deg", |scenario| {
            scenario.duration_s = 270.0;
            scenario.shocks.peak_g = [15.0, 20.0];
            scenario.shocks.per_minute = 6.0;
        });
        let (mut trace, truth) = simulate(&scenario, seed);
        let seen: Vec<f64> = truth
            .shocks
            .iter()
            .map(|shock| shock.start_s)
            .filter(|s| hardest_m_s2(&trace, *s) > STANDS_OUT_M_S2)
            .collect();
        let Some(first_s) = seen.iter().copied().find(|s| *s > 40.0) else { continue };
        // The last is seen for a minute.
        let Some(second_s) = seen.into_iter().find(|s| *s > first_s + 20.0 && *s < 165.0) else { continue };
        runs += 1;
        for (at_s, step) in [first_s, second_s].into_iter().zip(steps_deg_s) {
            for sample in trace.samples.iter_mut().filter(|sample| sample.t_us as f64 * 1e-6 > at_s) {
                let all = sample.gyro_rad_s.iter_mut().zip(step.iter());
                all.for_each(|(rate, step)| *rate += step.to_radians() as f32);
            }
        }
        let flight = fly(&of_trace(&trace), &trace.samples, |_| {}).unwrap();
        let mut times_s: Vec<f64> =
            flight.diagnoses.iter().flat_map(steps_of).map(|step| step.step_us as f64 * 1e-6).collect();
        times_s.sort_unstable_by(f64::total_cmp);
        times_s.dedup();
        let near = |at_s: f64| times_s.iter().any(|s| (s - at_s).abs() < 2.0);
        // A step that found no place is dated to a following shock.
        let is_of = |s: f64, at_s: f64| (-2.0..20.0).contains(&(s - at_s));
        others += times_s.iter().filter(|s| !is_of(**s, first_s) && !is_of(**s, second_s)).count();
        let steps_rad_s = (steps_deg_s[0] + steps_deg_s[1]).map(f64::to_radians);
        let new = Vector3::from(*truth.bias_rad_s.last().unwrap()).cast::<f64>() + steps_rad_s;
        let flown = Vector3::from(flight.reports.last().unwrap().flown.b_rad_s).cast::<f64>();
        let error_deg_s = (flown - new).norm().to_degrees();
        println!(
            "seed {seed}: at {first_s:.1} and {second_s:.1}; told {times_s:.1?}; bias off by {error_deg_s:.3} deg/s"
        );
        let least = steps_deg_s.map(|step| step.norm()).into_iter().fold(f64::INFINITY, f64::min);
        assert!(error_deg_s < 0.5 * least, "{seed}: {error_deg_s} of {least}");
        if !near(first_s) || !near(second_s) {
            continue;
        }
        both += 1;
        // After two minutes a step is settled: it has become part of the bias.
        for from_s in (0..).map(|k| second_s + 60.0 + 10.0 * f64::from(k)).take_while(|s| *s < 255.0) {
            let error_deg_s = rate_error_deg_s(&trace, &flight, from_s, from_s + 10.0);
            assert!(error_deg_s < 0.5 * least, "{seed}: {error_deg_s} of {least} deg/s from {from_s:.0} s on");
        }
    }
    println!("both in {both} of {runs}, {others} others");
    // All places are taken at one shock in 14 (Erlang: 6 a minute, each for 10 s, at 3 places): both find one
    // in 86 %, and of 8 runs fewer than 5 do so once in 40 times.
    assert!(runs >= 6 && 2 * both > runs, "both in {both} of {runs}");
    // A Bayes factor of e^5 comes of noise in one run in 150.
    assert!(others <= 1, "{others}");
}
