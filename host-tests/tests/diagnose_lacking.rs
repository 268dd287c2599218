//! The diagnosis loop with something missing: each run gets its verdict, nothing is named that cannot be
//! seen, and alternatives are stated.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod rig;

use meerkat_mwd::{SampleFlags, compensation::Sensor, diagnosis::Verdict};
use mwd::{
    diagnosis::{Diagnosed, against_reference, diagnosed},
    report::account::sentences,
};
use testbed::{
    flight::{Flight, configuration::of_trace, fly},
    simulate::{Effects, Scenario, Temperature, simulate},
    trace::Trace,
};

use rig::files::{FAST_ROTATION, recording};

/// Drilling at 45 deg for two minutes.
fn scenario(effects: Effects) -> Scenario {
    Scenario { duration_s: 120.0, effects, ..Scenario::default() }
}

fn lag_and_iron() -> Effects {
    Effects { mag_lag_ms: 12.0, hard_iron_ut: [5.0, -4.0, 0.0], ..Effects::default() }
}

fn run(scenario: &Scenario, seed: u64) -> Trace {
    scenario.validate().unwrap();
    simulate(scenario, seed).0
}

fn diagnose(trace: &Trace) -> Diagnosed {
    let config = of_trace(trace);
    diagnosed(trace, &config, &fly(&config, &trace.samples, |_| {}).unwrap())
}

fn names(diagnosed: &Diagnosed) -> Vec<&'static str> {
    diagnosed.effects.iter().map(|found| found.effect.name()).collect()
}

/// The same run with a thermometer shows it, so it is the thermometer that is missed.
#[test]
fn without_a_thermometer_no_temperature_is_blamed() {
    let mut warming = scenario(Effects { gyro_bias_temperature_deg_s_c: [0.12, -0.1, 0.15], ..Effects::default() });
    warming.temperature = Some(Temperature { start_c: 40.0, end_c: Some(80.0), ..Temperature::default() });
    let mut shown = 0;
    for seed in 0..4 {
        let mut trace = run(&warming, seed);
        shown += usize::from(names(&diagnose(&trace)).contains(&"gyro_bias_temperature"));
        for sample in &mut trace.samples {
            sample.temperature_c = 0.0;
            sample.flags |= SampleFlags::TEMPERATURE_MISSING;
        }
        let without = diagnose(&trace);
        assert!(!names(&without).contains(&"gyro_bias_temperature"), "{seed}: {:?}", names(&without));
        assert_ne!(without.verdict, Verdict::NotEnoughExcitation, "{seed}");
    }
    assert!(shown >= 2, "{shown} of 4");
}

#[test]
fn without_a_magnetometer_nothing_of_it_is_named() {
    for seed in 0..4 {
        let mut trace = run(&scenario(lag_and_iron()), seed);
        assert!(!diagnose(&trace).effects.is_empty(), "{seed}");
        for sample in &mut trace.samples {
            sample.mag_ut = [0.0; 3];
            sample.flags |= SampleFlags::MAG_MISSING;
        }
        let without = diagnose(&trace);
        let of_it = without.effects.iter().filter(|found| found.effect.sensor() == Sensor::Magnetometer).count();
        assert!(of_it == 0 && without.magnets.is_empty(), "{seed}: {:?}", names(&without));
        assert_eq!(without.residual.magnetic_deg.after, None, "{seed}");
    }
}

/// With 10 s to drill there is no verdict yet, and nothing is taken out.
#[test]
fn twenty_seconds_are_not_enough() {
    for seed in 0..4 {
        let trace = run(&Scenario { duration_s: 20.0, ..scenario(lag_and_iron()) }, seed);
        let short = diagnose(&trace);
        assert_eq!(short.verdict, Verdict::NotEnoughExcitation, "{seed}");
        assert!(short.effects.is_empty() && short.magnets.is_empty(), "{seed}");
    }
}

/// Without a rest the bias is not known beforehand: the same two show, and nothing else.
#[test]
fn without_a_rest_the_effects_are_named_all_the_same() {
    for seed in 0..4 {
        let moving = Scenario { rest_s: 0.0, ramp_s: 0.5, ..scenario(lag_and_iron()) };
        let found = diagnose(&run(&moving, seed));
        let mut names = names(&found);
        names.sort_unstable();
        assert_eq!(names, ["hard_iron", "mag_lag"], "{seed}");
    }
}

#[test]
fn a_probe_that_stands_still_shows_nothing() {
    for seed in 0..4 {
        let still = Scenario { rest_s: 118.0, ramp_s: 1.0, ..scenario(lag_and_iron()) };
        let found = diagnose(&run(&still, seed));
        assert_eq!(found.verdict, Verdict::NotEnoughExcitation, "{seed}");
        assert!(found.effects.is_empty() && found.magnets.is_empty(), "{seed}: {:?}", names(&found));
    }
}

/// A reference that is away for half a second out of ten, and for 5 s once, is as good as a whole one; one
/// that is hardly ever there is refused.
#[test]
fn a_reference_with_gaps_is_used_where_it_is() {
    for seed in 0..3 {
        let whole = run(&scenario(lag_and_iron()), seed);
        let with = |keep: fn(usize) -> bool| {
            let mut trace = whole.clone();
            trace.reference.iter_mut().enumerate().for_each(|(i, q)| *q = q.filter(|_| keep(i)));
            against_reference(&trace, &of_trace(&trace), None).map(|(_, diagnosed, _)| diagnosed)
        };
        let gaps = with(|i| i % 1_000 > 50 && !(6_000..6_500).contains(&i)).unwrap();
        let mut found = names(&gaps);
        found.sort_unstable();
        assert_eq!(found, ["hard_iron", "mag_lag"], "{seed}");
        let rare = with(|i| i % 500 == 0).map_or_else(|error| error.to_string(), |_| String::new());
        assert!(rare.contains("the reference covers only 25 of 12001 samples"), "{seed}: {rare}");
    }
}

/// Over half a second that is not there, within a segment, nothing says how the probe turned.
#[test]
fn nothing_is_predicted_over_a_gap_in_time() {
    let whole = recording(FAST_ROTATION);
    let mut cut = whole.clone();
    cut.samples.retain(|sample| !(2_000_000..2_500_000).contains(&(sample.t_us % 5_000_000)));
    let residual = |trace: &Trace| diagnosed(trace, &of_trace(trace), &Flight::default()).residual.gravity_deg;
    let [whole, cut] = [residual(&whole).before.unwrap(), residual(&cut).before.unwrap()];
    assert!(cut < 1.1 * whole, "{whole} -> {cut} deg");
}

/// A clock that was set while the probe ran: the residuals are those on both sides, and what lies between
/// costs nothing.
#[test]
fn a_gap_of_ages_has_no_residual() {
    let whole = run(&Scenario { duration_s: 60.0, ..scenario(lag_and_iron()) }, 1);
    let angles = |trace: &Trace| diagnosed(trace, &of_trace(trace), &Flight::default()).residual_over_time.before;
    for gap_us in [3_000_000, 30 * 86_400_000_000, 1_000_000_000_000_000_000] {
        let mut later = whole.clone();
        later.samples[4_000..].iter_mut().for_each(|sample| sample.t_us += gap_us);
        let gap_s = gap_us as f64 * 1e-6;
        for (angles, whole) in angles(&later).iter().zip(angles(&whole)) {
            let after = angles.iter().filter(|[t_s, _]| *t_s > gap_s).count();
            assert!(after > 15 && angles.len() + 2 >= whole.len(), "{gap_s} s: {} of {}", angles.len(), whole.len());
        }
    }
}

/// A delay of the magnetometer and eddy currents in the collar are one under axial rotation: one name with
/// the sum of both, which says that it could be the other.
#[test]
fn two_effects_that_cannot_be_told_apart_are_one_and_the_account_says_so() {
    for (seed, mag_lag_ms, eddy_lag_ms) in [(0, 6.0, 3.5), (1, 9.0, 2.5), (2, 5.0, 4.0)] {
        let found = diagnose(&run(&scenario(Effects { mag_lag_ms, eddy_lag_ms, ..Effects::default() }), seed));
        let [one] = &found.effects[..] else { panic!("{seed}: {:?}", names(&found)) };
        assert!(["mag_lag", "eddy_lag"].contains(&one.effect.name()), "{seed}: {}", one.effect.name());
        let lag_ms = 1e3 * f64::from(one.report.found.parameters[0]);
        assert!((lag_ms / (mag_lag_ms + eddy_lag_ms) - 1.0).abs() < 0.2, "{seed}: {lag_ms}");
        let other = if one.effect.name() == "mag_lag" { "eddy_lag" } else { "mag_lag" };
        assert!(sentences(&found)[0].contains(other), "{seed}: {:?}", sentences(&found));
    }
}
