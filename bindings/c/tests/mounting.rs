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

/// Turns the probe by hand about each axis, there and back, and pushes every sample into probe and check.
fn turn(probe: *mut MwdProbe, check: *mut MwdMountingCheck, turned_round: Option<usize>) -> MwdMounting {
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
            sample.accel_m_s2 = (body_to_earth.inverse() * Vector3::new(0.0, 0.0, -9.81)).into();
            sample.mag_ut = (body_to_earth.inverse() * Vector3::new(20.0, 4.0, 42.0)).into();
            // SAFETY: objects from their `_init`, and structs of their own.
            unsafe {
                assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Ok);
                assert_eq!(mwd_mounting_check_push(check, probe, &sample, &mut found), MwdStatus::Ok);
            }
        }
    }
    found
}

#[test]
fn a_turn_on_which_sensors_do_not_agree_is_named() {
    for (turned_round, wrong) in CASES {
        let (mut one, mut other) = (vec![0_u64; MWD_PROBE_SIZE / 8], vec![0_u64; MWD_MOUNTING_CHECK_SIZE / 8]);
        let (mut probe, mut check) = (ptr::null_mut(), ptr::null_mut());
        let mut config = MwdConfig::from(&meerkat_mwd::Config::default());
        let mut found = MwdMounting::default();
        // SAFETY: storage of the size that the macros say, and structs of their own.
        unsafe {
            let bytes = MWD_MOUNTING_CHECK_SIZE;
            assert_eq!(mwd_probe_init(one.as_mut_ptr().cast(), MWD_PROBE_SIZE, &mut probe), MwdStatus::Ok);
            assert_eq!(mwd_mounting_check_init(other.as_mut_ptr().cast(), bytes, &mut check), MwdStatus::Ok);
            let sample = MwdSample::default();
            let before = mwd_mounting_check_push(check, probe, &sample, &mut found);
            assert_eq!(before, MwdStatus::ErrorNotConfigured);
            let nowhere = mwd_mounting_check_push(ptr::null_mut(), probe, &sample, &mut found);
            assert_eq!(nowhere, MwdStatus::ErrorNull);
            config.sample_period_us = 10_000;
            assert_eq!(mwd_probe_configure(probe, &config), MwdStatus::Ok);
        }
        let found = turn(probe, check, turned_round);
        assert_eq!((found.seen, found.wrong), (63, wrong), "{turned_round:?}");
        assert!((found.gravity_m_s2 - 9.81).abs() < 0.05 && (found.field_ut - 46.69).abs() < 0.1, "{found:?}");
    }
}
