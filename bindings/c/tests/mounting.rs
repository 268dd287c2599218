//! A probe whose sensors do not agree on a turn accepts nothing, and says about which axis.
#![allow(unsafe_code, clippy::unwrap_used, missing_docs)]

use meerkat_mwd::nalgebra::{Rotation3, Vector3};
use meerkat_mwd_c::*;
use std::ptr;

/// Axis of the gyro whose sign is turned round; the turns that then are wrong.
const CASES: [(Option<usize>, u32); 4] = [
    (None, 0),
    (Some(0), MWD_TURN_X_BY_ACCEL | MWD_TURN_X_BY_MAG),
    (Some(1), MWD_TURN_Y_BY_ACCEL | MWD_TURN_Y_BY_MAG),
    (Some(2), MWD_TURN_Z_BY_ACCEL | MWD_TURN_Z_BY_MAG),
];

/// Readings of gravity and field in the body frame.
fn vectors(body_to_earth: &Rotation3<f32>) -> [[f32; 3]; 2] {
    [[0.0, 0.0, -9.81], [20.0, 4.0, 42.0]].map(|v| (body_to_earth.inverse() * Vector3::from(v)).into())
}

/// Turns the probe by hand about each axis, there and back, and pushes every sample into probe and check. Returns what
/// the check found, and where the probe lies.
fn turn(
    probe: *mut MwdProbe,
    check: *mut MwdMountingCheck,
    turned_round: Option<usize>,
) -> (MwdMounting, Rotation3<f32>) {
    let (mut output, mut found) = (MwdOutput::default(), MwdMounting::default());
    let mut body_to_earth = Rotation3::new(Vector3::new(0.4, -0.9, 1.7));
    let mut t_us = 0;
    for axis in [0, 1, 2].repeat(4) {
        for k in 0..400_u16 {
            t_us += 10_000;
            let rate = Vector3::ith(axis, if k < 200 { 1.5 } else { -1.1 });
            body_to_earth *= Rotation3::new(rate * 0.01);
            let mut sample = MwdSample { t_us, ..MwdSample::default() };
            sample.gyro_rad_s = rate.into();
            if let Some(axis) = turned_round {
                sample.gyro_rad_s[axis] *= -1.0;
            }
            [sample.accel_m_s2, sample.mag_ut] = vectors(&body_to_earth);
            // SAFETY: objects from their `_init`, and structs of their own.
            unsafe {
                assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Ok);
                assert_eq!(mwd_mounting_check_push(check, probe, &sample, &mut found), MwdStatus::Ok);
            }
        }
    }
    (found, body_to_earth)
}

/// Leaves the probe where it lies, and returns the grade of the survey that it gives.
fn grade_at_rest(
    (probe, check, surveyor): (*mut MwdProbe, *mut MwdMountingCheck, *mut MwdSurveyor),
    lies: &Rotation3<f32>,
) -> u32 {
    let (mut output, mut found) = (MwdOutput::default(), MwdMounting::default());
    let mut survey = std::mem::MaybeUninit::<MwdSurvey>::uninit();
    for k in 0..3_000_u32 {
        // Readings that stay the same to the bit are those of a frozen sensor.
        let noise = (k.wrapping_mul(2_654_435_761) >> 20) as f32 * 1e-6;
        let mut sample = MwdSample { t_us: 48_010_000 + u64::from(k) * 10_000, ..MwdSample::default() };
        sample.gyro_rad_s = [noise, 0.0 - noise, 0.5 * noise];
        [sample.accel_m_s2, sample.mag_ut] = vectors(lies).map(|v| v.map(|x| x + noise));
        let mut news = 0;
        // SAFETY: objects from their `_init`, and structs of their own.
        unsafe {
            assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Ok);
            assert_eq!(mwd_mounting_check_push(check, probe, &sample, &mut found), MwdStatus::Ok);
            assert_eq!(mwd_surveyor_push(surveyor, probe, &sample, &output, &mut news), MwdStatus::Ok);
        }
    }
    // SAFETY: memory for a survey, which the call fills when it returns `Ok`.
    unsafe {
        assert_eq!(mwd_surveyor_latest(surveyor, MWD_SURVEY_STATIONARY, survey.as_mut_ptr()), MwdStatus::Ok);
        survey.assume_init().grade
    }
}

#[test]
fn a_turn_on_which_sensors_do_not_agree_is_named() {
    for (turned_round, wrong) in CASES {
        let [mut one, mut other, mut third] =
            [MWD_PROBE_SIZE, MWD_MOUNTING_CHECK_SIZE, MWD_SURVEYOR_SIZE].map(|bytes| vec![0_u64; bytes / 8]);
        let (mut probe, mut check, mut surveyor) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
        let mut config = MwdConfig::from(&meerkat_mwd::Config::default());
        let mut found = MwdMounting::default();
        // SAFETY: storage of the size that the macros say, and structs of their own.
        unsafe {
            let bytes = MWD_MOUNTING_CHECK_SIZE;
            assert_eq!(mwd_probe_init(one.as_mut_ptr().cast(), MWD_PROBE_SIZE, &mut probe), MwdStatus::Ok);
            assert_eq!(mwd_mounting_check_init(other.as_mut_ptr().cast(), bytes, &mut check), MwdStatus::Ok);
            let bytes = MWD_SURVEYOR_SIZE;
            assert_eq!(mwd_surveyor_init(third.as_mut_ptr().cast(), bytes, &mut surveyor), MwdStatus::Ok);
            let sample = MwdSample::default();
            let before = mwd_mounting_check_push(check, probe, &sample, &mut found);
            assert_eq!(before, MwdStatus::ErrorNotConfigured);
            let nowhere = mwd_mounting_check_push(ptr::null_mut(), probe, &sample, &mut found);
            assert_eq!(nowhere, MwdStatus::ErrorNull);
            config.sample_period_us = 10_000;
            assert_eq!(mwd_probe_configure(probe, &config), MwdStatus::Ok);
            assert_eq!(mwd_surveyor_configure(surveyor, &config), MwdStatus::Ok);
        }
        let (found, lies) = turn(probe, check, turned_round);
        assert_eq!((found.seen, found.wrong), (63, wrong), "{turned_round:?}");
        assert!((found.gravity_m_s2 - 9.81).abs() < 0.05 && (found.field_ut - 46.69).abs() < 0.1, "{found:?}");
        let grade = grade_at_rest((probe, check, surveyor), &lies);
        assert_eq!(grade, if wrong == 0 { MWD_GRADE_GOOD } else { MWD_GRADE_BAD }, "{turned_round:?}");
    }
}
