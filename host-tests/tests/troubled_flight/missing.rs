//! Rows that are not there, cells that are empty, and gaps in time.

use meerkat_mwd::{Sample, SampleFlags, attitude::AttitudeFlags, identification::Refusal};
use testbed::simulate::Scenario;

use crate::rig::{
    files::scenario,
    run::{Dice, Run, accepted, flagged, of_scenario, refusal, run, within},
};

fn without(run: &Run, from_s: f64, to_s: f64) -> Vec<Sample> {
    let kept = |s: &&Sample| !(from_s..to_s).contains(&(s.t_us as f64 * 1e-6));
    run.trace.samples.iter().filter(kept).copied().collect()
}

/// Steps of more than three periods, as the trace format defines a gap.
fn gaps(samples: &[Sample], period_us: u64) -> u32 {
    samples.windows(2).filter(|pair| pair[1].t_us - pair[0].t_us > 3 * period_us).count() as u32
}

#[test]
fn a_tenth_of_the_rows_missing_costs_the_attitude_little_and_no_window_is_late() {
    for seed in [1, 2, 3] {
        let run = run(120.0, seed);
        let mut dice = Dice::new(seed);
        let kept: Vec<Sample> = run.trace.samples.iter().filter(|_| dice.roll() >= 0.1).copied().collect();
        let flight = run.fly(&kept);
        let counters = flight.counters;
        assert_eq!(counters.gaps, gaps(&kept, 10_000));
        assert_eq!(flagged(&flight, AttitudeFlags::AFTER_GAP) as u32, counters.gaps);
        assert!(counters.overruns == 0 && counters.reports_lost == 0, "{counters:?}");
        // Windows close every 25 s of time, whatever is missing in them.
        let ends: Vec<f64> = flight.reports.iter().map(|r| (r.t_end_us as f64 * 1e-6).round()).collect();
        assert_eq!(ends, [50.0, 75.0, 100.0]);
        run.never_worse_than_bias_only(&flight);

        let run = run.calibrated();
        let (full, thinned) = (run.fly(&run.trace.samples), run.fly(&kept));
        let (all, all_tilt) = run.rms_deg(&full, 5.0, 120.0);
        let (some, some_tilt) = run.rms_deg(&thinned, 5.0, 120.0);
        println!(
            "seed {seed}: {all:.2} -> {some:.2} deg, tilt {all_tilt:.2} -> {some_tilt:.2} deg, {} gaps, {} windows",
            counters.gaps,
            flight.reports.len()
        );
        // Each gap hides a turn of some 10 deg, until gravity and field are found again.
        assert!(some < 5.0 && some_tilt < 2.5);
    }
}

#[test]
fn a_tenth_of_a_sensors_cells_missing_does_not_stop_identification() {
    for (sensor, missing) in
        [("gyro", SampleFlags::GYRO_MISSING), ("accel", SampleFlags::ACCEL_MISSING), ("mag", SampleFlags::MAG_MISSING)]
    {
        for seed in [1, 2, 3] {
            let run = run(60.0, seed);
            let mut dice = Dice::new(seed);
            let samples = run.with(|_, s| s.flags.set(missing, dice.roll() < 0.1));
            let absent = samples.iter().filter(|s| s.flags.contains(missing)).count();
            let flight = run.fly(&samples);
            let held = flagged(&flight, AttitudeFlags::GYRO_HELD);
            let gyro = missing == SampleFlags::GYRO_MISSING;
            assert_eq!((flight.counters.gyro_missing as usize, held), if gyro { (absent, absent) } else { (0, 0) });
            assert!(run.identified(&flight.reports[0]), "{sensor} seed {seed}: {:?}", flight.reports[0]);

            let run = run.calibrated();
            let (all, all_tilt) = run.rms_deg(&run.fly(&run.trace.samples), 5.0, 60.0);
            let (some, some_tilt) = run.rms_deg(&run.fly(&samples), 5.0, 60.0);
            println!("    attitude {all:.2} -> {some:.2} deg, tilt {all_tilt:.2} -> {some_tilt:.2} deg");
            assert!(some < 1.5 * all + 1.0 && some_tilt < 1.5 * all_tilt + 0.5);
        }
    }
}

/// At one sample an interval nothing stands in for a missing one, and no second is complete: that is the
/// gyro's fault, not a lack of excitation.
#[test]
fn too_many_missing_readings_are_named_as_the_reason() {
    let run = run(60.0, 3);
    // A tenth of a second at most is told by the rates on either side.
    let bridged = run.fly(&run.with(|index, s| s.flags.set(SampleFlags::GYRO_MISSING, index % 40 < 4)));
    assert!(accepted(&bridged.reports[0]), "{:?}", bridged.reports[0]);
    let samples = run.with(|index, s| s.flags.set(SampleFlags::GYRO_MISSING, index % 100 < 60));
    let flight = run.fly(&samples);
    let Some(Refusal::GyroUnusable { share }) = refusal(&flight.reports[0]) else { panic!("{:?}", flight.reports[0]) };
    assert_eq!(share, 1.0);
    let never = run.fly(&run.with(|_, s| s.flags.insert(SampleFlags::GYRO_MISSING)));
    assert!(matches!(refusal(&never.reports[0]), Some(Refusal::GyroUnusable { .. })));
    assert!(never.outputs.iter().all(|o| o.attitude.is_some()));
}

#[test]
fn after_a_gap_of_three_seconds_the_attitude_recovers_and_identification_goes_on() {
    for seed in [1, 2, 3] {
        let run = run(125.0, seed);
        let samples = without(&run, 60.0, 63.0);
        let flight = run.fly(&samples);
        assert_eq!(flight.counters.gaps, 1);
        let after: Vec<_> = flight
            .outputs
            .iter()
            .filter(|o| o.attitude.unwrap().flags.contains(AttitudeFlags::AFTER_GAP))
            .map(|o| o.t_us)
            .collect();
        assert_eq!(after, [63_000_000]);
        let spans: Vec<_> = flight.reports.iter().map(|r| (r.t_start_us, r.t_end_us, r.t_effect_us)).collect();
        let seconds = |s: u64| s * 1_000_000;
        let window = |end_s: u64| (seconds(end_s - 50), seconds(end_s), Some(seconds(end_s + 1)));
        assert_eq!(spans, [50, 75, 100].map(window));
        assert!(accepted(&flight.reports[0]));
        run.never_worse_than_bias_only(&flight);

        let run = run.calibrated();
        let flight = run.fly(&samples);
        let (first, _) = run.rms_deg(&flight, 63.0, 63.5);
        let (total, tilt) = run.rms_deg(&flight, 65.0, 75.0);
        let ratio = run.worst_tilt_in_sigmas(&flight, 5.0);
        println!(
            "seed {seed}: {first:.1} deg in the first half second, then {total:.2}, tilt {tilt:.2}, worst {ratio:.2} sigma"
        );
        assert!(total < 3.0 && tilt < 1.5 && ratio < 5.0);
        assert!(within(&flight, 65.0, 66.0).all(|o| o.attitude.unwrap().sigma_azimuth_rad < 0.3));
    }
}

#[test]
fn the_rest_of_the_flight_is_identified_when_the_gap_comes_first() {
    for (from_s, to_s) in [(12.0, 15.0), (30.0, 33.0)] {
        let run = run(100.0, 3);
        let flight = run.fly(&without(&run, from_s, to_s));
        let last = flight.reports.iter().rfind(|r| accepted(r)).expect("an accepted window");
        assert!(run.identified(last), "{from_s}");
    }
}

/// A gap counts nothing into the latency of a result, however long it is.
#[test]
fn a_gap_costs_no_result() {
    let run = run(130.0, 3);
    for (from_s, to_s) in [(50.01, 59.0), (50.5, 59.0), (50.99, 60.0), (40.0, 48.0), (60.0, 69.0)] {
        let flight = run.fly(&without(&run, from_s, to_s));
        assert!(flight.reports.iter().any(accepted), "{from_s}: {:?}", flight.reports);
        assert_eq!(flight.counters.overruns, 0, "{from_s}");
        run.never_worse_than_bias_only(&flight);
    }
}

/// As a wireless recording has them: every window closes in its time, and what is identified between the gaps flies.
#[test]
fn a_gap_each_ten_to_twenty_seconds_ends_no_window() {
    for seed in [1, 2, 3] {
        let run = run(160.0, seed);
        let mut dice = Dice::new(seed);
        let mut lost = Vec::new();
        let mut at_s = 10.0 + 10.0 * dice.roll();
        while at_s < 155.0 {
            lost.push((at_s, at_s + 0.2 + 1.3 * dice.roll()));
            at_s += 10.0 + 10.0 * dice.roll();
        }
        let is_kept = |s: &&Sample| {
            let t_s = s.t_us as f64 * 1e-6;
            !lost.iter().any(|(from_s, to_s)| (*from_s..*to_s).contains(&t_s))
        };
        let kept: Vec<Sample> = run.trace.samples.iter().filter(is_kept).copied().collect();
        let flight = run.fly(&kept);
        assert_eq!(flight.counters.gaps as usize, lost.len());
        assert!(lost.len() >= 7 && flight.counters.overruns == 0, "{seed}: {:?}", flight.counters);
        // A window that would close in a gap closes at the first sample behind it.
        let ends_s: Vec<f64> = flight.reports.iter().map(|report| report.t_end_us as f64 * 1e-6).collect();
        let due_s = [50.0, 75.0, 100.0, 125.0, 150.0];
        assert!(ends_s.len() == due_s.len(), "{seed}: {ends_s:?}");
        assert!(ends_s.iter().zip(due_s).all(|(end, due)| (-0.02..1.6).contains(&(end - due))), "{seed}: {ends_s:?}");
        assert!(flight.reports.iter().any(accepted), "{seed}: {:?}", flight.reports);
        run.never_worse_than_bias_only(&flight);
    }
}

#[test]
fn the_last_result_takes_effect_at_the_first_sample_of_the_hold_out_wherever_that_lies_between_samples() {
    // The latency is not a whole number of these periods.
    let scenario = Scenario { duration_s: 66.0, sample_period_us: 3_500, ..scenario("drilling_45deg") };
    let run = of_scenario(&scenario, 3);
    for freeze_us in [60_000_000, 60_001_500, 60_002_000, 60_003_499] {
        let first = run.trace.samples.iter().map(|s| s.t_us).find(|&t| t >= freeze_us);
        let flight = run.fly_frozen(Some(freeze_us), &run.trace.samples);
        assert_eq!(flight.reports.last().map(|r| r.t_effect_us), Some(first), "{freeze_us}");
    }
}

#[test]
fn nothing_new_takes_effect_after_a_freeze_even_across_a_gap() {
    let run = run(100.0, 3);
    for (from_s, to_s) in [(30.0, 70.0), (50.0, 58.0), (58.0, 62.0), (59.5, 62.0), (54.0, 90.0)] {
        let flight = run.fly_frozen(Some(60_000_000), &without(&run, from_s, to_s));
        for report in &flight.reports {
            let in_time = report.t_effect_us.is_none_or(|t| t <= 60_000_000);
            // Over ten seconds it takes two samples for a gap to be believed.
            let ends_us = (to_s * 1e6) as u64 + if to_s - from_s > 10.0 { 10_000 } else { 0 };
            let due_in_the_gap = report.t_end_us <= 59_000_000 && report.t_effect_us == Some(ends_us);
            assert!(in_time || due_in_the_gap, "{from_s}: {report:?}");
        }
        assert_eq!(flight.counters.overruns, 0, "{from_s}");
    }
}
