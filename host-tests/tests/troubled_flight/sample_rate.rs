//! The same motion, sampled at other rates.

use mwd::{flight::fly, simulate::Scenario};

use crate::rig::{Run, accepted, of_scenario, scenario};

/// One window and its latency.
fn sampled(sample_period_us: u32, seed: u64) -> Run {
    let mut scenario = Scenario { duration_s: 56.0, sample_period_us, ..scenario("drilling_45deg.toml") };
    if sample_period_us > 20_000 {
        // Below half the sample rate.
        scenario.vibration.angular_band_hz = [2.0, 8.0];
    }
    of_scenario(&scenario, seed)
}

/// Systematic rate error of the accepted model, deg/s, in the worst of the seeds.
fn worst_rate_error(sample_period_us: u32, seeds: u64) -> f64 {
    let mut worst = 0.0;
    for seed in 0..seeds {
        let run = sampled(sample_period_us, seed);
        let flight = run.fly(&run.trace.samples);
        assert_eq!(flight.counters.overruns, 0, "{sample_period_us} us");
        assert_eq!(flight.reports.len(), 1);
        let report = &flight.reports[0];
        assert!(accepted(report), "{sample_period_us} us, seed {seed}: {report:?}");
        let [_, _, flown] = run.rate_errors_deg_s(report);
        worst = f64::max(worst, flown);
    }
    println!(
        "{sample_period_us:6} us, {:7.1} Hz: {worst:.4} deg/s, worst of {seeds}",
        1e6 / f64::from(sample_period_us)
    );
    worst
}

#[test]
fn from_100_hz_to_1_khz_the_model_is_accepted_and_accurate() {
    for period_us in [10_000, 5_000, 2_500, 1_000] {
        assert!(worst_rate_error(period_us, 4) < 0.1, "{period_us}");
    }
}

#[test]
fn so_it_is_at_periods_that_make_no_20_ms() {
    for period_us in [9_999, 9_000, 7_001, 6_000, 5_800, 3_500, 3_333, 1_234] {
        assert!(worst_rate_error(period_us, 2) < 0.1, "{period_us}");
    }
}

/// A gyro that means over its sample loses little down to the slowest rate that is taken; increments there are up to 40 ms.
#[test]
fn at_50_to_80_hz_it_is_accurate_too() {
    for period_us in [20_000, 19_000, 16_667, 15_000, 13_334, 12_500] {
        assert!(worst_rate_error(period_us, 4) < 0.12, "{period_us}");
    }
}

#[test]
fn at_10_khz_it_works() {
    assert!(worst_rate_error(100, 1) < 0.1);
}

/// 30 Hz at 180 deg/s is 6 deg a sample, 12 deg at the top of stick-slip.
#[test]
fn at_20_to_30_hz_it_works() {
    for period_us in [33_333, 50_000] {
        assert!(worst_rate_error(period_us, 4) < 0.2, "{period_us}");
    }
}

#[test]
fn a_slower_period_is_refused_by_name() {
    let mut run = sampled(20_000, 1);
    run.config.sample_period_us = 50_001;
    let error = fly(&run.config, &run.trace.samples, |_| {}).unwrap_err();
    assert_eq!(error.field, "sample_period_us");
    assert!(error.to_string().contains("20 Hz"), "{error}");
}

/// Two samples missing of each five: under the nominal period of 50 Hz they come at 30 Hz. The attitude goes on, and nothing is
/// identified from intervals that no sample fell into.
#[test]
fn samples_that_come_at_30_hz_under_a_nominal_50_hz_stream_an_attitude_and_identify_nothing() {
    let run = sampled(20_000, 1).calibrated();
    let samples: Vec<_> = run
        .trace
        .samples
        .iter()
        .enumerate()
        .filter(|(index, _)| [0, 2, 3].contains(&(index % 5)))
        .map(|(_, s)| *s)
        .collect();
    let flight = run.fly(&samples);
    assert_eq!(flight.counters.gaps, 0);
    assert!(flight.reports.iter().all(|r| !accepted(r)), "{:?}", flight.reports);
    let (total, tilt) = run.rms_deg(&flight, 5.0, 56.0);
    println!("30 Hz under 50 Hz: {total:.2} deg, tilt {tilt:.2} deg, {:?}", flight.reports[0].decision);
    assert!(total < 25.0 && tilt < 10.0);
}
