//! Motion that does not determine the parameters is refused with a reason, and the old values stay.

use meerkat_mwd::compensation::VectorModel;
use mwd::calibrate::{Verdict, calibrate, record};
use nalgebra::{UnitQuaternion, Vector3};
use testbed::flight::configuration::freeze_at_us;

use crate::turntable::{Probe, Random, all_around};

fn kept(verdict: &Verdict) -> &str {
    assert!(matches!(verdict, Verdict::Kept(_)), "{verdict:?}");
    if let Verdict::Kept(reason) = verdict { reason } else { "" }
}

#[test]
fn one_orientation_is_refused_by_name() {
    let mut random = Random::new(1);
    let probe = Probe::drawn(&mut random);
    // The same attitude again and again, with another one between that is no rest.
    let here = random.attitude();
    let there = here * UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 0.3));
    let found = calibrate(&[probe.turned(&[here, there, here, there, here], &mut random)], None, None).unwrap();
    let accel = found.accel.as_ref().unwrap();
    let reason = kept(&accel.verdict);
    assert!(reason.contains("of 9 directions") && reason.contains("scale_x"), "{reason}");
    assert!(accel.spread.orientations <= 2 && accel.fit.rank < 4);
    assert_eq!(found.accel_model(), VectorModel::IDENTITY);
    assert_eq!(found.mag_model(), VectorModel::IDENTITY);
    assert_eq!(found.alignment, None, "no sensor is on record");
}

#[test]
fn turning_about_one_axis_leaves_what_lies_along_it() {
    for seed in 0..10 {
        let mut random = Random::new(seed);
        let probe = Probe::drawn(&mut random);
        // The body's x stays east: gravity and the field turn in the y-z plane.
        let about_east = |k: usize| {
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2)
                * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5 * k as f64)
        };
        let attitudes: Vec<_> = (0..26).map(about_east).collect();
        let found = calibrate(&[probe.turned(&attitudes, &mut random)], None, None).unwrap();
        let accel = found.accel.as_ref().unwrap();
        let reason = kept(&accel.verdict);
        assert!(reason.contains("scale_x") && reason.contains("offset_x"), "seed {seed}: {reason}");
        assert!(!reason.contains("scale_y") && !reason.contains("offset_z"), "seed {seed}: {reason}");
        assert!(accel.spread.smallest < 0.02, "{:?}", accel.spread);
        // An offset of the magnetometer along x, which may be large, also looks like scales across.
        let reason = kept(&found.mag.as_ref().unwrap().verdict);
        assert!(reason.contains("scale_x"), "seed {seed}: {reason}");
        assert_eq!(found.accel_model(), VectorModel::IDENTITY);
    }
}

#[test]
fn a_cap_of_orientations_is_refused_or_right() {
    // Within 60 deg of one attitude; what is let through has to be right to the 0.3 deg that it is let
    // through for.
    for seed in 0..20 {
        let mut random = Random::new(300 + seed);
        let probe = Probe::drawn(&mut random);
        let near = |random: &mut Random| {
            UnitQuaternion::from_scaled_axis(random.normal3().normalize() * 1.05 * random.uniform())
        };
        let attitudes: Vec<_> = (0..24).map(|_| near(&mut random)).collect();
        let found = calibrate(&[probe.turned(&attitudes, &mut random)], None, None).unwrap();
        let accel = found.accel.unwrap();
        let error =
            (0..9).map(|k| (accel.model().offset[k % 3] - probe.accel_errors[6 + k % 3]).abs()).fold(0.0, f64::max);
        assert!(!accel.is_new() || error < 0.1, "seed {seed}: {error} m/s^2 let through");
    }
}

/// A magnetometer that swings as on a leg: what no turn determines is not told in figures, and no unit is blamed.
#[test]
fn turns_that_do_not_suffice_are_told_as_that_alone() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("leg.csv");
    for seed in 0..12 {
        let mut random = Random::new(900 + seed);
        let mut probe = Probe::drawn(&mut random);
        probe.mag_errors = [0.0; 9];
        let swing = |k: usize| {
            let a = 0.5 * (0.7 * k as f64).sin();
            UnitQuaternion::from_scaled_axis(Vector3::new(0.05 * (0.01 * k as f64).sin(), a, 0.1 * a))
        };
        let attitudes: Vec<_> = (0..16).map(swing).collect();
        let mut trace = probe.turned(&attitudes, &mut random);
        trace.keys.magnetic_field_ut = None;
        // Iron beside the way disturbs the field slowly.
        for (k, sample) in trace.samples.iter_mut().enumerate() {
            let (sine, cosine) = (0.002 * k as f64).sin_cos();
            sample.mag_ut[0] += 2.0 * sine as f32;
            sample.mag_ut[1] += cosine as f32;
        }
        trace.write(&path).unwrap();
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_mwd")).arg("calibrate").arg(&path).output().unwrap();
        let told = String::from_utf8(output.stdout).unwrap();
        let of_mag = told.split("MAGNETOMETER").nth(1).unwrap();
        assert!(!of_mag.contains("inf ") && !of_mag.contains("check the magnetometer's unit"), "seed {seed}: {of_mag}");
        let mag = calibrate(&[trace], None, None).unwrap().mag.unwrap();
        let reason = kept(&mag.verdict);
        let is_short = reason.contains("turns do not suffice");
        assert_eq!(
            is_short,
            !of_mag.contains("1-sigma") && !of_mag.contains("error of the norm"),
            "seed {seed}: {of_mag}"
        );
        assert!(is_short || mag.fit.freedom >= 1.0, "seed {seed}: {of_mag}");
    }
}

#[test]
fn few_rests_leave_nothing_to_check_by() {
    let mut random = Random::new(2);
    let probe = Probe::drawn(&mut random);
    let attitudes = all_around(6, &mut random);
    let found = calibrate(&[probe.turned(&attitudes, &mut random)], None, None).unwrap();
    kept(&found.accel.unwrap().verdict);
}

/// Nothing can be held out of so few, so nothing says that the new values are better.
#[test]
fn few_rests_leave_a_record_as_it_is() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("old.toml");
    std::fs::write(&file, "[accel]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\noffset = [0.25, 0, 0]\n").unwrap();
    for (seed, rests) in (0..10).zip([3, 4, 5, 6, 7].into_iter().cycle()) {
        let mut random = Random::new(seed);
        let probe = Probe::drawn(&mut random);
        let attitudes = all_around(rests, &mut random);
        let found = calibrate(&[probe.turned(&attitudes, &mut random)], Some(&file), None).unwrap();
        let accel = found.accel.as_ref().unwrap();
        assert!(accel.held_out.is_some() || !accel.is_new(), "{rests} rests: {:?}", accel.verdict);
    }
}

/// The probe was sound when its record was made, and is again at the end; between, both sensors had other errors.
#[test]
fn what_is_worse_on_the_part_held_out_does_not_go_on_record() {
    let mut random = Random::new(5);
    let [sound, disturbed] = [(); 2].map(|()| Probe::drawn(&mut random));
    let attitudes = all_around(36, &mut random);
    let [sound, mut trace] = [sound, disturbed].map(|probe| probe.turned(&attitudes, &mut random));
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("old.toml");
    record::write(&calibrate(std::slice::from_ref(&sound), None, None).unwrap(), &file).unwrap();
    let from_us = freeze_at_us(&trace, 0.33);
    let from = trace.samples.partition_point(|sample| sample.t_us < from_us);
    trace.samples.truncate(from);
    trace.samples.extend_from_slice(&sound.samples[from..]);
    let found = calibrate(&[trace], Some(&file), Some(0.33)).unwrap();
    for (sensor, check) in [(&found.accel, &found.later), (&found.mag, &found.mag_later)] {
        let check = check.as_ref().unwrap();
        assert!(check.count > 5 && check.after > 3.0 * check.before, "{check:?}");
        let why = kept(&sensor.as_ref().unwrap().verdict);
        assert!(why.contains("worse on the part held out"), "{why}");
    }
    assert!(record::text(&found).is_none());
    // A sound part that is held out confirms.
    let found = calibrate(&[sound], None, Some(0.33)).unwrap();
    let check = found.mag_later.as_ref().unwrap();
    assert!(check.after < 0.2 * check.before && found.mag.as_ref().unwrap().is_new(), "{check:?}");
}

#[test]
fn on_a_record_that_was_there_before_only_what_is_determined_changes() {
    let mut random = Random::new(3);
    let mut probe = Probe::drawn(&mut random);
    probe.accel_errors = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.3, 0.3];
    let about_x = |k: usize| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5 * k as f64);
    let attitudes: Vec<_> = (0..26).map(about_x).collect();
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("old.toml");
    std::fs::write(&file, "[accel]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\noffset = [0.25, 0, 0]\n").unwrap();
    let found = calibrate(&[probe.turned(&attitudes, &mut random)], Some(&file), None).unwrap();
    assert!(matches!(found.accel.as_ref().unwrap().verdict, Verdict::Partly(_)), "{:?}", found.accel.unwrap().verdict);
    let offset = found.accel_model().offset;
    assert!((offset[0] - 0.25).abs() < 0.01, "x cannot be seen: {offset:?}");
    assert!((offset[1] - 0.3).abs() < 0.02 && (offset[2] - 0.3).abs() < 0.02, "{offset:?}");
}
