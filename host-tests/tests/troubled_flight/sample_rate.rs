//! The same motion, sampled at other rates.

use testbed::{flight::fly, simulate::Scenario};

use crate::rig::{
    files::scenario,
    run::{Run, of_scenario},
};

/// One window and its latency.
fn sampled(sample_period_us: u32, seed: u64) -> Run {
    let mut scenario = Scenario { duration_s: 56.0, sample_period_us, ..scenario("drilling_45deg") };
    if sample_period_us > 20_000 {
        // Below half the sample rate.
        scenario.vibration.angular_band_hz = [2.0, 8.0];
    }
    of_scenario(&scenario, seed)
}

/// Each window is accepted in time, and leaves a tenth of the rate error at most.
fn identified(sample_period_us: u32, seeds: u64) {
    for seed in 0..seeds {
        let run = sampled(sample_period_us, seed);
        let flight = run.fly(&run.trace.samples);
        assert_eq!(flight.counters.overruns, 0, "{sample_period_us} us");
        assert_eq!(flight.reports.len(), 1);
        print!("{sample_period_us:6} us, {:7.1} Hz: ", 1e6 / f64::from(sample_period_us));
        assert!(run.identified(&flight.reports[0]), "{sample_period_us} us, seed {seed}: {:?}", flight.reports[0]);
    }
}

#[test]
fn from_100_hz_to_1_khz_the_model_is_accepted_and_accurate() {
    for period_us in [10_000, 5_000, 2_500, 1_000] {
        identified(period_us, 4);
    }
}

#[test]
fn so_it_is_at_periods_that_make_no_20_ms() {
    for period_us in [9_999, 9_000, 7_001, 6_000, 5_800, 3_500, 3_333, 1_234] {
        identified(period_us, 2);
    }
}

/// A gyro that means over its sample loses little down to the slowest rate that is taken; increments there
/// are up to 50 ms.
#[test]
fn at_50_to_80_hz_it_is_accurate_too() {
    for period_us in [20_000, 19_000, 16_667, 15_000, 13_334, 12_500] {
        identified(period_us, 4);
    }
}

#[test]
fn at_10_khz_it_works() {
    identified(100, 1);
}

/// 30 Hz at 180 deg/s is 6 deg a sample, 12 deg at the top of stick-slip.
#[test]
fn at_20_to_30_hz_it_works() {
    for period_us in [33_333, 50_000] {
        identified(period_us, 4);
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

/// Two samples missing of each five: under the nominal period of 50 Hz they come at 30 Hz. The attitude goes
/// on, and what is identified does no harm.
#[test]
fn samples_that_come_at_30_hz_under_a_nominal_50_hz_stream_an_attitude_and_harm_nothing() {
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
    run.never_worse_than_bias_only(&flight);
    let (total, tilt) = run.rms_deg(&flight, 5.0, 56.0);
    println!("30 Hz under 50 Hz: {total:.2} deg, tilt {tilt:.2} deg, {:?}", flight.reports[0].decision);
    assert!(total < 25.0 && tilt < 10.0);
}
