//! Sensors that fail while a whole probe drills: the attitude flags it, its sigmas grow with its errors, and
//! it recovers.

use meerkat_mwd::{Sample, SampleFlags};
use testbed::simulate::{Hole, Rotation, Scenario};

use crate::{
    simulation::Noise,
    troubled::{flown, flown_in},
};

fn clipped(x: f32, limit: f32) -> f32 {
    if x.abs() < limit { x } else { limit.copysign(x) }
}

/// Start of the trouble, seconds.
const FROM_S: f64 = 60.0;

#[test]
fn a_magnet_for_a_minute_turns_the_heading_by_less_than_5_deg() {
    let mut noise = Noise::new(5);
    for (seed, size_ut) in [8.6, 20.0, 35.0, 58.0].into_iter().enumerate() {
        let magnet = noise.vector().normalize() * size_ut;
        let flight = flown(FROM_S + 90.0, seed as u64, |t, sample| {
            let there = ((t - FROM_S) / 0.5).clamp(0.0, 1.0) - ((t - FROM_S - 60.0) / 0.5).clamp(0.0, 1.0);
            for (reading, add) in sample.mag_ut.iter_mut().zip(magnet.iter()) {
                *reading += (there * add) as f32;
            }
        });
        let seen = flight.seen(FROM_S, FROM_S + 90.0);
        println!("{size_ut} uT: {seen:?}");
        assert!(seen.azimuth_deg < 5.0 && seen.tilt_deg < 2.0, "{size_ut} uT: {seen:?}");
    }
}

#[test]
fn within_two_seconds_of_the_start_it_is_there_and_it_did_not_jump() {
    let mut noise = Noise::new(11);
    for seed in 0..12 {
        let [inclination_deg, azimuth_deg] = [(noise.normal() * 40.0).abs() + 2.0, noise.normal() * 100.0];
        let rotation = Rotation { toolface_deg: noise.normal() * 100.0, ..Rotation::default() };
        let hole = Hole { inclination_deg, azimuth_deg, ..Hole::default() };
        let flight = flown_in(
            Scenario { duration_s: 10.0, rest_s: 10.0, hole, rotation, ..Scenario::default() },
            seed,
            None,
            |_, _| {},
        );
        let (start, later) = (flight.seen(0.0, 2.0), flight.seen(2.0, 10.0));
        println!("{inclination_deg:.0} deg: {start:?} {later:?}");
        // The first field reading errs by 0.2 uT in 21.
        assert!(start.jump_deg < 2.5, "{start:?}");
        assert!(later.jump_deg < 0.2 && later.tilt_deg < 0.5, "{later:?}");
        assert!(inclination_deg < 5.0 || later.azimuth_deg < 1.0, "{later:?}");
    }
}

/// A trouble: name, length in seconds, and how it changes a sample at a time since its start.
type Trouble = (&'static str, f64, fn(f64, &mut Sample));

/// Troubles of the vector sensors, one by one: the gyro carries the attitude meanwhile.
const VECTOR_TROUBLES: [Trouble; 12] = [
    ("5 s without magnetometer", 5.0, |_, s| s.flags.insert(SampleFlags::MAG_MISSING)),
    ("60 s without accelerometer", 60.0, |_, s| s.flags.insert(SampleFlags::ACCEL_MISSING)),
    ("free fall", 3.0, |t, s| s.accel_m_s2 = [0.05 * (9.0 * t).sin() as f32, 0.04, -0.05]),
    ("zero field", 10.0, |_, s| s.mag_ut = [0.0; 3]),
    ("noise for a field", 10.0, |t, s| s.mag_ut = [0.3 * (70.0 * t).sin() as f32, 0.2 * (90.0 * t).cos() as f32, 0.1]),
    ("dead axis of the accelerometer", 10.0, |_, s| s.accel_m_s2[0] = 0.0),
    ("dead axis of the magnetometer", 10.0, |_, s| s.mag_ut[2] = 0.0),
    ("stuck axis of the accelerometer", 10.0, |_, s| s.accel_m_s2[1] = 0.7),
    ("stuck axis of the magnetometer", 10.0, |_, s| s.mag_ut[0] = 12.5),
    ("swapped signs of the accelerometer", 10.0, |_, s| s.accel_m_s2 = s.accel_m_s2.map(|x| -x)),
    ("swapped signs of the magnetometer", 10.0, |_, s| s.mag_ut = s.mag_ut.map(|x| -x)),
    ("not a number", 10.0, |_, s| (s.accel_m_s2[1], s.mag_ut[0]) = (f32::NAN, f32::INFINITY)),
];

#[test]
fn failing_vector_sensors_are_flagged_and_the_gyro_carries_the_attitude_over() {
    for (index, (name, length_s, spoil)) in VECTOR_TROUBLES.into_iter().enumerate() {
        let flight = flown(FROM_S + length_s + 40.0, index as u64, |t, sample| {
            if (FROM_S..FROM_S + length_s).contains(&t) {
                spoil(t - FROM_S, sample);
            }
        });
        let (during, after) =
            (flight.seen(FROM_S, FROM_S + length_s), flight.seen(FROM_S + length_s + 20.0, FROM_S + length_s + 40.0));
        let back = flight.seen(FROM_S + length_s - 0.05, FROM_S + length_s + 20.0);
        println!("{name}: {during:.2?}\n  back {back:.2?}\n  after {after:.2?}");
        // It is noticed within half a second to one and a half.
        assert!(during.flagged > 0.5, "{name}: {during:?}");
        for seen in [&during, &back] {
            assert!(seen.tilt_sigmas < 4.0 && seen.azimuth_sigmas < 4.0 && seen.jump_sigmas < 1.0, "{name}: {seen:?}");
        }
        assert!(after.tilt_deg < 2.0 && after.azimuth_deg < 2.0 && after.flagged < 0.1, "{name}: {after:?}");
    }
}

/// Troubles of the gyro: nothing carries the rotation meanwhile, and the sigmas must say so. From [`UNTOLD`]
/// on the readings look like any others, each another jump: only the field contradicts them, from the first
/// reading on.
const GYRO_TROUBLES: [Trouble; 5] = [
    ("gyro missing", 2.0, |_, s| s.flags.insert(SampleFlags::GYRO_MISSING)),
    ("gyro not a number", 2.0, |_, s| s.gyro_rad_s[2] = f32::NAN),
    ("gyro frozen", 3.0, |_, s| s.gyro_rad_s = [0.011, -0.02, 2.9]),
    ("dead axis of the gyro", 3.0, |_, s| s.gyro_rad_s[2] = 0.0),
    ("swapped signs of the gyro", 3.0, |_, s| s.gyro_rad_s = s.gyro_rad_s.map(|x| -x)),
];

const UNTOLD: usize = 3;

#[test]
fn a_failing_gyro_is_flagged_and_the_attitude_found_again() {
    for (index, (name, length_s, spoil)) in GYRO_TROUBLES.into_iter().enumerate() {
        let flight = flown(FROM_S + length_s + 80.0, index as u64, |t, sample| {
            if (FROM_S..FROM_S + length_s).contains(&t) {
                spoil(t - FROM_S, sample);
            }
        });
        let (during, after) =
            (flight.seen(FROM_S, FROM_S + length_s), flight.seen(FROM_S + length_s + 60.0, FROM_S + length_s + 80.0));
        let back = flight.seen(FROM_S + length_s - 0.05, FROM_S + length_s + 60.0);
        println!("{name}: {during:.2?}\n  back {back:.2?}\n  after {after:.2?}");
        assert!(during.flagged > 0.5, "{name}: {during:?}");
        assert!(after.tilt_deg < 2.0 && after.azimuth_deg < 2.0 && after.flagged < 0.1, "{name}: {after:?}");
        for seen in [&during, &back] {
            assert!(seen.tilt_sigmas < 4.0 && seen.azimuth_sigmas < 4.0, "{name}: {seen:?}");
        }
        assert!(back.jump_sigmas < 1.0 && (index >= UNTOLD || during.jump_sigmas < 1.0), "{name}: {during:?} {back:?}");
    }
}

#[test]
fn a_gyro_that_lies_while_the_probe_turns_is_in_doubt_within_hundredths_of_a_second() {
    let mut noise = Noise::new(17);
    let (mut untold, mut worst_s, mut flights) = (0.0, 0.0_f64, 0);
    for seed in 0..12 {
        let inclination_deg = (10.0 + noise.normal().abs() * 40.0).min(90.0);
        let (azimuth_deg, mean_rpm) = (noise.normal() * 100.0, 30.0 + noise.normal().abs() * 45.0);
        for (name, length_s, spoil) in GYRO_TROUBLES.into_iter().skip(UNTOLD) {
            let rotation = Rotation { mean_rpm, stick_slip: 0.5, ..Rotation::default() };
            let hole = Hole { inclination_deg, azimuth_deg, ..Hole::default() };
            let scenario =
                Scenario { duration_s: FROM_S + length_s, rest_s: 20.0, rotation, hole, ..Scenario::default() };
            let flight = flown_in(scenario, seed, None, |t, sample| {
                if t >= FROM_S {
                    spoil(t - FROM_S, sample);
                }
            });
            let seen = flight.seen(FROM_S, FROM_S + length_s);
            println!("{inclination_deg:.0} deg to {azimuth_deg:.0}, {mean_rpm:.0} rpm, {name}: {seen:.2?}");
            untold += seen.untold;
            worst_s = worst_s.max(seen.untold * length_s);
            flights += 1;
        }
    }
    let share = untold / f64::from(flights);
    println!("more than 4 sigmas off: {:.2} % of the samples, at most {worst_s:.2} s of a flight", 100.0 * share);
    assert!(share < 0.02 && worst_s < 0.5, "{share}, {worst_s} s");
}

#[test]
fn a_gyro_that_saturates_in_every_slip_is_flagged_and_the_sigmas_hold() {
    // 60 rpm with full stick-slip: up to 12.6 rad/s, of which the gyro reads 8.7 (500 deg/s).
    let rotation = Rotation { mean_rpm: 60.0, stick_slip: 0.95, ..Rotation::default() };
    let hole = Hole { inclination_deg: 45.0, azimuth_deg: 60.0, ..Hole::default() };
    let scenario = Scenario { duration_s: 80.0, rest_s: 20.0, rotation, hole, ..Scenario::default() };
    let limit = 8.7_f32;
    let clip = |sample: &mut Sample| sample.gyro_rad_s = sample.gyro_rad_s.map(|x| clipped(x, limit));
    let flight = flown_in(scenario, 3, Some(limit), |_, sample| clip(sample));
    let during = flight.seen(30.0, 80.0);
    println!("{during:.2?}");
    assert!(during.flagged > 0.2 && during.tilt_sigmas < 4.0 && during.azimuth_sigmas < 4.0, "{during:?}");
    assert!(during.jump_sigmas < 1.0, "{during:?}");
}

#[test]
fn after_a_slip_that_saturated_the_gyro_the_attitude_comes_back() {
    let rotation = Rotation { mean_rpm: 30.0, stick_slip: 0.4, ..Rotation::default() };
    let hole = Hole { inclination_deg: 45.0, azimuth_deg: 60.0, ..Hole::default() };
    let scenario = Scenario { duration_s: 100.0, rest_s: 20.0, rotation, hole, ..Scenario::default() };
    let flight = flown_in(scenario, 4, Some(8.7), |t, sample| {
        if (60.0..62.0).contains(&t) {
            // Readings of a gyro whose range is a third too small.
            sample.gyro_rad_s = sample.gyro_rad_s.map(|x| clipped(x, 2.0));
            sample.flags.set(SampleFlags::GYRO_CLIPPED, sample.gyro_rad_s[2] >= 2.0);
        }
    });
    let (during, after) = (flight.seen(60.0, 70.0), flight.seen(80.0, 100.0));
    println!("{during:.2?}\n{after:.2?}");
    assert!(during.tilt_sigmas < 4.0 && during.azimuth_sigmas < 4.0 && during.jump_sigmas < 1.0, "{during:?}");
    assert!(after.tilt_deg < 2.0 && after.azimuth_deg < 2.0 && after.flagged < 0.1, "{after:?}");
}
