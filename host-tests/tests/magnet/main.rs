//! A magnet that is brought to the probe and taken away again is found, and nothing else is taken for one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::needless_range_loop, missing_docs)]

#[path = "../rig/mod.rs"]
mod rig;
mod runs;

use meerkat_mwd::Config;
use nalgebra::Vector3;
use runs::{Magnet, direction_across, drilling, heading_rms_deg, iron_taken_out, watch, watch_with};
use testbed::flight::configuration::of_trace;

use rig::files::{ATTACHED_MAGNET, recording};
use rig::handheld::{self, GyroError, KINDS, Kind, Random};

/// Components across the tool axis: in a vertical hole nothing shows an offset along it.
fn across(v: [f32; 3]) -> Vector3<f64> {
    Vector3::new(f64::from(v[0]), f64::from(v[1]), 0.0)
}

#[test]
fn clean_drilling_runs_hold_no_magnet() {
    for seed in 0..100 {
        let watched = watch(&drilling(seed, [50.0, 120.0], 0.0));
        assert_eq!(watched.counts.intervals, 0, "{seed}: {:?}", watched.intervals);
        assert_eq!(watched.counts.suspicions, 0, "{seed}");
    }
}

#[test]
fn disturbances_fixed_in_the_earth_are_no_magnets_and_do_no_harm() {
    let (mut claimed, mut suspicions, mut squares) = (0, 0, [0.0; 2]);
    for seed in 0..100 {
        let trace = drilling(seed, [50.0, 120.0], 4.0);
        let watched = watch(&trace);
        claimed += usize::from(watched.counts.intervals > 0);
        suspicions += watched.counts.suspicions;
        for (sum, effects) in squares.iter_mut().zip([true, false]) {
            *sum += heading_rms_deg(&trace, effects).powi(2);
        }
    }
    assert!(claimed <= 1, "{claimed} of 100");
    assert!(suspicions > 100, "the bursts are seen: {suspicions}");
    let [with, without] = squares.map(|sum: f64| (sum / 100.0).sqrt());
    println!("heading with bursts: {with:.1} deg rms, without the watch {without:.1}");
    // The diagnosis flies as well: never worse by more than a twentieth, whatever is in the field.
    assert!(with < 1.05 * without, "{with} {without}");
}

#[test]
fn magnets_on_a_drilling_probe_are_found_with_their_times_and_sizes() {
    let (mut found, mut squares) = (0, [0.0; 2]);
    let runs = 40;
    for seed in 1000..1000 + runs {
        let random = &mut Random::new(seed);
        let mut trace = drilling(seed, [100.0, 120.0], 0.0);
        let on_s = random.between(12.0, 40.0);
        let magnet = Magnet {
            offset_ut: direction_across(random, 0.3) * random.between(8.0, 40.0),
            on_s,
            off_s: on_s + random.between(15.0, 50.0),
            ramp_s: random.between(0.05, 2.0),
        };
        magnet.attach(&mut trace);
        let watched = watch(&trace);
        for (sum, effects) in squares.iter_mut().zip([true, false]) {
            *sum += heading_rms_deg(&trace, effects).powi(2);
        }
        let [interval] = watched.intervals[..] else {
            println!("{seed}: {magnet:?}, found {:?}", watched.intervals);
            continue;
        };
        let near = |us: u64, edge_s: f64| (us as f64 * 1e-6 - edge_s).abs() < 1.0 + 0.5 * magnet.ramp_s;
        let edges = near(interval.from_us, magnet.on_s) && interval.to_us.is_some_and(|to| near(to, magnet.off_s));
        let error = across(interval.offset_ut) - across((magnet.offset_ut.cast::<f32>()).into());
        let sigma = across(interval.sigma_ut).norm();
        let size = error.norm() < 4.0 * sigma + 0.5 && error.norm() < 0.25 * magnet.offset_ut.norm();
        found += u64::from(edges && size);
        if !(edges && size) {
            println!("{seed}: {magnet:?}, found {interval:?}");
        }
    }
    let [with, without] = squares.map(|sum: f64| (sum / runs as f64).sqrt());
    println!("{found} of {runs}; heading {with:.1} deg rms, without the watch {without:.1}");
    assert!(found * 10 >= runs * 9, "{found} of {runs}");
    assert!(with < without, "{with} {without}");
}

#[test]
fn motion_by_hand_holds_a_magnet_only_where_one_was_attached() {
    for error in [GyroError::Factory, GyroError::Percent(0.05)] {
        for kind in KINDS {
            for fast in [false, true] {
                let (trace, _) = handheld::record(kind, fast, error, 90.0, 700 + kind as u64);
                let watched = watch(&trace);
                let most = usize::from(kind == Kind::MagnetAttached);
                assert!(watched.intervals.len() <= most, "{kind:?} {fast} {error:?}: {:?}", watched.intervals);
            }
        }
    }
}

/// Times and size from the optical reference: what the field is more than the earth's, h(t) = m(t + 14 ms) -
/// C^T B, with B from the parts without a magnet, is half of its later self at 42.65 s and 99.4 s, and (0.5,
/// 0.0, -8.4) microtesla in between.
#[test]
fn the_magnet_of_a_real_recording_is_found_and_no_longer_turns_the_heading() {
    let trace = recording(ATTACHED_MAGNET);
    let watched = watch(&trace);
    let [interval] = watched.intervals[..] else { panic!("{:?}", watched.intervals) };
    let first_s = trace.samples[0].t_us as f64 * 1e-6;
    println!("{interval:?} {first_s}");
    assert!((interval.from_us as f64 * 1e-6 - 42.65).abs() < 1.0);
    assert!((interval.to_us.unwrap() as f64 * 1e-6 - 99.4).abs() < 1.0);
    assert!((interval.offset() - Vector3::new(0.5, 0.0, -8.4)).norm() < 1.0);
    let (with, without) = (heading_rms_deg(&trace, true), heading_rms_deg(&trace, false));
    println!("heading {with:.2} deg rms, without the watch {without:.2}");
    assert!(with < 5.0 && with < 0.4 * without, "{with} {without}");
}

/// One that is there before the probe turns counts as the probe's own iron, and is taken out as that. It must not stay
/// taken out when it has gone.
#[test]
fn a_magnet_that_was_there_from_the_start_is_not_taken_out_when_it_has_gone() {
    let (mut with, mut left) = (0, Vec::new());
    let runs = 12;
    for run in 0..runs {
        let random = &mut Random::new(run);
        let (mut trace, _) = handheld::record(Kind::Rotation, run % 2 == 1, GyroError::Factory, 180.0, 800 + run);
        let (off_s, size_ut) = (random.between(80.0, 110.0), random.between(5.0, 9.0));
        let offset_ut = random.direction() * size_ut;
        Magnet { offset_ut, on_s: -10.0, off_s, ramp_s: 0.5 }.attach(&mut trace);
        let taken_out = iron_taken_out(&trace, &[off_s - 1.0, 179.0]);
        println!(
            "{run}: {size_ut:.1} uT, off {:.1} before, {:.1} left",
            (taken_out[0] - offset_ut).norm(),
            taken_out[1].norm()
        );
        with += usize::from((taken_out[0] - offset_ut).norm() < 0.5 * size_ut);
        left.push(taken_out[1].norm());
    }
    println!("taken out of {with} of {runs}; afterwards, uT: {left:.1?}");
    assert!(with >= 6, "{with} of {runs}");
    // The sensors have iron of their own, which stays.
    assert!(left.iter().all(|left| *left < 5.0), "{left:.1?}");
}

#[test]
fn a_magnet_that_came_after_the_freeze_is_not_learned_any_more() {
    let trace = recording(ATTACHED_MAGNET);
    let (config, freeze_us) = (of_trace(&trace), trace.samples[0].t_us + 1_000_000);
    let watched = watch_with(&trace, &config, freeze_us);
    assert_eq!(watched.intervals.iter().map(|i| i.is_corrected()).collect::<Vec<_>>(), [false]);
    // Withheld from the first suspicion until the magnet is gone.
    assert!(watched.unused > 0.9, "{}", watched.unused);
    let off = watch_with(&trace, &Config { effects: false, ..config }, freeze_us);
    assert!(off.intervals.is_empty() && off.counts.suspicions == 0);
}
