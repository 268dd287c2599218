//! Times that jump, end, stand still or go back.

use meerkat_mwd::{Probe, Sample, attitude::AttitudeFlags, identification::Refusal};

use crate::rig::run::{flagged, flown, refusal, run, sound, within};
use testbed::flight::Flight;

fn shifted(samples: &[Sample], by_us: u64) -> Vec<Sample> {
    samples.iter().map(|s| Sample { t_us: s.t_us.checked_add(by_us).unwrap(), ..*s }).collect()
}

#[test]
fn a_jump_of_hours_is_a_gap_and_the_flight_goes_on() {
    for hours in [1, 10, 24 * 365 * 100] {
        let run = run(120.0, 3);
        let jump_us = hours * 3_600_000_000;
        let samples = run.with(|index, s| s.t_us += if index >= 6_000 { jump_us } else { 0 });
        let flight = run.fly(&samples);
        assert_eq!((flight.counters.gaps, flight.counters.overruns), (1, 0));
        assert_eq!(flagged(&flight, AttitudeFlags::AFTER_GAP), 1);
        assert!(flight.outputs.iter().all(|o| o.attitude.is_some()));
        let ends: Vec<u64> = flight.reports.iter().map(|r| r.t_end_us).collect();
        // Windows are due every 25 s of time: after so many hours the next one at once.
        assert_eq!(ends, [50_000_000, 65_000_000 + jump_us, 75_000_000 + jump_us, 100_000_000 + jump_us]);
    }
}

#[test]
fn where_time_begins_changes_nothing() {
    let run = run(120.0, 3);
    let at_zero = run.fly(&run.trace.samples);
    let length_us = run.trace.duration_us();
    for by_us in [1, 1_700_000_000_000_000, u64::MAX - length_us] {
        let flight = flown(&run.config, &shifted(&run.trace.samples, by_us));
        assert_eq!(flight.outputs.len(), at_zero.outputs.len());
        assert_eq!(flight.reports.len(), at_zero.reports.len());
        for (here, there) in at_zero.outputs.iter().zip(&flight.outputs) {
            assert_eq!((here.rate_rad_s, here.attitude), (there.rate_rad_s, there.attitude));
        }
        for (here, there) in at_zero.reports.iter().zip(&flight.reports) {
            assert_eq!(here.t_end_us + by_us, there.t_end_us);
            assert_eq!((here.bias_only, here.flown, here.decision), (there.bias_only, there.flown, there.decision));
        }
    }
}

#[test]
fn the_last_instants_of_time_are_flown_without_overflow() {
    let run = run(70.0, 3);
    for tail_s in [0, 1, 4, 30, 52, 57, 70] {
        let start = u64::MAX - tail_s * 1_000_000;
        let mut samples = run.trace.samples.clone();
        samples.iter_mut().for_each(|s| s.t_us = start.saturating_add(s.t_us));
        samples.push(Sample { t_us: u64::MAX, ..samples[0] });
        for freeze_at_us in [None, Some(0), Some(u64::MAX), Some(u64::MAX - 3_000_000)] {
            let flight = run.fly_frozen(freeze_at_us, &samples);
            assert!(flight.counters.out_of_order > 0 && flight.outputs.iter().all(|o| o.attitude.is_some()));
        }
    }
    let jump = [0, 10_000, u64::MAX / 2, u64::MAX - 1, u64::MAX].map(|t_us| Sample { t_us, ..run.trace.samples[0] });
    // The second of the two jumps is the first that another stamp confirms.
    assert_eq!(flown(&run.config, &jump).counters.gaps, 1);
}

#[test]
fn samples_out_of_order_are_counted_and_leave_no_trace() {
    let run = run(60.0, 3);
    let clean = run.fly(&run.trace.samples);
    // Every hundredth sample is followed by itself and by one from the past, with other readings.
    let mut samples = Vec::new();
    for (index, sample) in run.trace.samples.iter().enumerate() {
        samples.push(*sample);
        if index % 100 == 99 {
            samples.push(Sample { gyro_rad_s: [9.0; 3], ..*sample });
            samples.push(Sample { t_us: sample.t_us - 500_000, accel_m_s2: [50.0; 3], ..*sample });
        }
    }
    let flight = run.fly(&samples);
    assert_eq!(flight.counters.out_of_order as usize, samples.len() - run.trace.samples.len());
    assert_eq!((flight.outputs, flight.reports), (clean.outputs, clean.reports));
    assert_eq!(flight.counters.samples, clean.counters.samples);
}

#[test]
fn one_time_stamp_far_ahead_costs_its_own_sample_and_no_other() {
    let run = run(30.0, 3);
    for ahead_us in [10_500_000, 60_000_000, 3_600_000_000, u64::MAX / 2] {
        let samples = run.with(|index, s| s.t_us += if index == 1_000 { ahead_us } else { 0 });
        let flight = run.fly(&samples);
        assert_eq!((flight.counters.out_of_order, flight.counters.gaps), (1, 0), "{ahead_us}");
        assert_eq!(flight.outputs.len(), samples.len() - 1, "{ahead_us}");
        // The same flight as if that sample had never been read.
        let without: Vec<Sample> =
            samples.iter().enumerate().filter(|(index, _)| *index != 1_000).map(|(_, s)| *s).collect();
        let clean = run.fly(&without);
        assert_eq!((flight.outputs, flight.reports), (clean.outputs, clean.reports), "{ahead_us}");
    }
}

#[test]
fn a_stamp_less_than_ten_seconds_ahead_makes_the_others_old_until_it_is_reached() {
    let run = run(30.0, 3);
    let samples = run.with(|index, s| s.t_us += if index == 1_000 { 5_000_000 } else { 0 });
    let flight = run.fly(&samples);
    assert_eq!(flight.counters.out_of_order, 500);
    assert!(within(&flight, 15.01, 31.0).all(|o| o.attitude.is_some()));
}

#[test]
fn steps_of_a_microsecond_are_taken() {
    let run = run(30.0, 3);
    let samples: Vec<Sample> = (0..60_000).map(|k| Sample { t_us: k, ..run.trace.samples[k as usize % 900] }).collect();
    let flight = flown(&run.config, &samples);
    assert_eq!(flight.counters.gaps, 0);
}

#[test]
fn a_probe_that_is_configured_again_forgets_everything() {
    let run = run(80.0, 3);
    let fresh = run.fly(&run.trace.samples);
    let mut probe = Box::new(Probe::new());
    assert_eq!(probe.push(&run.trace.samples[0]), None, "not configured");
    for late_us in [1_000_000_000_000, 0] {
        // The first flight is later in time, is never polled in its second half, and ends in the middle of a
        // job.
        probe.configure(&run.config).unwrap();
        let mut flight = Flight::default();
        for (index, sample) in shifted(&run.trace.samples, late_us).iter().enumerate() {
            flight.outputs.extend(probe.push(sample));
            if late_us == 0 || index < 4_000 {
                flight.reports.extend(probe.poll(probe.poll_budget()));
                flight.diagnoses.extend(probe.take_diagnosis());
            }
        }
        flight.counters = probe.counters();
        sound(&flight, run.trace.samples.len());
        if late_us == 0 {
            // Models that flew are noted by a flight, not by the probe.
            flight.models.clone_from(&fresh.models);
            assert_eq!(flight, fresh);
        } else {
            assert!(flight.counters.overruns > 0);
        }
    }
    assert!(fresh.reports.iter().all(|r| refusal(r) != Some(Refusal::Overrun)));
}

#[test]
fn a_clock_that_goes_back_for_good_begins_afresh_flagged_and_counted() {
    let run = run(60.0, 3);
    for back_us in [12_000_000, 25_000_000] {
        let samples = run.with(|index, s| s.t_us -= if index >= 3_000 { back_us } else { 0 });
        let mut probe = Box::new(Probe::new());
        probe.configure(&run.config).unwrap();
        let outputs: Vec<_> = samples.iter().map(|sample| (probe.push(sample), probe.began_afresh())).collect();
        // One stamp is doubted, the second is believed.
        assert!(outputs[3_000].0.is_none());
        let (first, began) = outputs[3_001];
        assert!(began && outputs.iter().filter(|(_, began)| *began).count() == 1);
        assert_eq!(first.unwrap().t_us, samples[3_001].t_us);
        assert!(first.unwrap().attitude.is_none_or(|it| it.flags.contains(AttitudeFlags::AFTER_GAP)));
        assert!(outputs[3_400..].iter().all(|(output, _)| output.unwrap().attitude.is_some()));
        let counters = probe.counters();
        assert_eq!((counters.out_of_order, counters.gaps, counters.samples), (1, 1, samples.len() as u64 - 1));
    }
}

#[test]
fn a_clock_that_goes_back_a_little_is_waited_for_and_the_wait_is_a_gap() {
    let run = run(60.0, 3);
    let samples = run.with(|index, s| s.t_us -= if index >= 1_500 { 4_000_000 } else { 0 });
    let flight = run.fly(&samples);
    assert_eq!(flight.counters.gaps, 1);
    let back = flight
        .outputs
        .windows(2)
        .position(|pair| pair[1].attitude.is_some_and(|it| it.flags.contains(AttitudeFlags::AFTER_GAP)));
    let [before, after] = [0, 1].map(|k| flight.outputs[back.unwrap() + k].attitude.unwrap());
    // Four seconds went by in which the tool may have turned.
    assert!(after.sigma_toolface_rad > 2.0 * before.sigma_toolface_rad, "{before:?} {after:?}");
}

/// Gap of twelve seconds in which the tool turned on: the estimator has to know of it, too. Taken for an instant, it
/// would be an error of the sensors.
#[test]
fn a_clock_that_stands_still_is_a_gap_and_no_error_of_the_sensors() {
    for (seed, from) in (0..6).flat_map(|seed| [170, 600, 1_100, 2_000].map(|from| (seed, from))) {
        let run = run(130.0, seed);
        let stood = run.trace.samples[from].t_us;
        let samples = run.with(|index, s| {
            if (from..from + 1_200).contains(&index) {
                s.t_us = stood;
            } else if index >= from + 1_200 {
                s.t_us -= 12_000_000 - 10_000;
            }
        });
        let flight = run.fly(&samples);
        assert_eq!((flight.counters.gaps, flight.counters.out_of_order), (1, 1_199));
        let named: usize = flight.diagnoses.iter().map(|report| report.found().count()).sum();
        assert_eq!(named, 0, "seed {seed}, sample {from}: {:?}", flight.diagnoses.last());
    }
}
