//! Whatever a caller hands over, a call comes back with a code and leaves what it was not allowed to change.
#![allow(unsafe_code, clippy::unwrap_used, missing_docs)]

use meerkat_mwd_c::*;
use std::{ffi::CStr, ptr};

/// Storage of the right alignment.
fn storage(bytes: usize) -> Vec<u64> {
    vec![u64::MAX; bytes / 8]
}

fn config() -> MwdConfig {
    let mut config = MwdConfig::from(&meerkat_mwd::Config::default());
    // SAFETY: a struct of its own.
    assert_eq!(unsafe { mwd_config_default(&mut config) }, MwdStatus::Ok);
    config
}

fn reason(config: &MwdConfig, room: usize) -> (MwdStatus, String) {
    let mut text = vec![1; room];
    // SAFETY: `room` bytes.
    let status = unsafe { mwd_config_validate(config, text.as_mut_ptr(), room) };
    // SAFETY: the call ends the text by a zero.
    (status, unsafe { CStr::from_ptr(text.as_ptr()) }.to_str().unwrap().to_owned())
}

#[test]
fn storage_that_is_null_misaligned_or_small_is_refused() {
    let mut memory = storage(MWD_PROBE_SIZE);
    let mut probe = ptr::null_mut();
    let start = memory.as_mut_ptr();
    // SAFETY: no call may touch what it refuses.
    unsafe {
        assert_eq!(mwd_probe_init(ptr::null_mut(), MWD_PROBE_SIZE, &mut probe), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_init(start.cast(), MWD_PROBE_SIZE, ptr::null_mut()), MwdStatus::ErrorNull);
        let askew = start.cast::<u8>().add(1).cast();
        assert_eq!(mwd_probe_init(askew, MWD_PROBE_SIZE - 8, &mut probe), MwdStatus::ErrorMisaligned);
        assert_eq!(mwd_probe_init(start.cast(), MWD_PROBE_SIZE / 2, &mut probe), MwdStatus::ErrorTooSmall);
        assert!(probe.is_null() && memory.iter().all(|word| *word == u64::MAX));
    }
}

#[test]
fn nothing_flies_before_a_configuration() {
    let (mut one, mut other, mut third) =
        (storage(MWD_PROBE_SIZE), storage(MWD_SURVEYOR_SIZE), storage(MWD_ATTITUDE_FILTER_SIZE));
    let (mut probe, mut surveyor, mut filter) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
    let (sample, mut output, mut news) = (MwdSample::default(), MwdOutput::default(), 0);
    let mut attitude = MwdAttitude::default();
    // SAFETY: storage of the size that the macros say, and structs of their own.
    unsafe {
        assert_eq!(mwd_probe_init(one.as_mut_ptr().cast(), MWD_PROBE_SIZE, &mut probe), MwdStatus::Ok);
        assert_eq!(mwd_surveyor_init(other.as_mut_ptr().cast(), MWD_SURVEYOR_SIZE, &mut surveyor), MwdStatus::Ok);
        let bytes = MWD_ATTITUDE_FILTER_SIZE;
        assert_eq!(mwd_attitude_filter_init(third.as_mut_ptr().cast(), bytes, &mut filter), MwdStatus::Ok);

        assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::ErrorNotConfigured);
        assert_eq!(mwd_probe_push(ptr::null_mut(), &sample, &mut output), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_push(probe, ptr::null(), &mut output), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_push(probe, &sample, ptr::null_mut()), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_poll_budget(probe), 0);
        let pushed = mwd_surveyor_push(surveyor, probe, &sample, &output, &mut news);
        assert_eq!(pushed, MwdStatus::ErrorNotConfigured);
        let rate = [0.0; 3].as_ptr();
        let turned = mwd_attitude_filter_push(filter, 0.01, rate, ptr::null(), ptr::null(), &mut attitude);
        assert_eq!(turned, MwdStatus::ErrorNotConfigured);

        let config = config();
        assert_eq!(mwd_probe_configure(probe, &config), MwdStatus::Ok);
        assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Ok);
        // Its time does not increase.
        assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Nothing);
        let mut counters = MwdCounters::default();
        assert_eq!(mwd_probe_counters(probe, &mut counters), MwdStatus::Ok);
        assert_eq!((counters.samples, counters.out_of_order), (1, 1));
        assert_eq!(mwd_attitude_filter_start(filter, &config), MwdStatus::Ok);
        let rate = [f32::NAN; 3];
        let turned = mwd_attitude_filter_push(filter, 0.01, rate.as_ptr(), ptr::null(), ptr::null(), &mut attitude);
        assert_eq!(turned, MwdStatus::ErrorArgument);
        let (rate, force) = ([0.0; 3], [0.0, 0.0, -9.8]);
        let push =
            |attitude| mwd_attitude_filter_push(filter, 0.01, rate.as_ptr(), force.as_ptr(), ptr::null(), attitude);
        assert!((0..200).any(|_| push(&mut attitude) == MwdStatus::Ok));
        assert!(attitude.inclination_rad < 0.01 && attitude.sigma_inclination_rad > 0.0, "{attitude:?}");
    }
}

#[test]
fn a_bad_field_is_named_and_the_text_never_overruns() {
    assert_eq!(reason(&config(), 80), (MwdStatus::Ok, String::new()));
    let bad = MwdConfig { earth_dip_rad: 60.0, ..config() };
    let whole = (MwdStatus::ErrorConfig, "earth.dip_rad must be -pi/2 to pi/2".to_owned());
    assert_eq!(reason(&bad, 80), whole);
    assert_eq!(reason(&bad, 6), (MwdStatus::ErrorConfig, "earth".to_owned()));
    assert_eq!(reason(&bad, 1).1, "");
    let status = |config: MwdConfig| reason(&config, 80);
    assert_eq!(status(MwdConfig { version: 0, ..config() }).0, MwdStatus::ErrorVersion);
    assert_eq!(status(MwdConfig { effects: 2, ..config() }), (MwdStatus::ErrorConfig, "effects must be 0 or 1".into()));
    assert_eq!(status(MwdConfig { identification_motion: 9, ..config() }).0, MwdStatus::ErrorConfig);
    // SAFETY: a NULL is allowed.
    unsafe {
        assert_eq!(mwd_config_validate(&bad, ptr::null_mut(), 80), MwdStatus::ErrorConfig);
        assert_eq!(mwd_config_validate(ptr::null(), ptr::null_mut(), 0), MwdStatus::ErrorNull);
        assert_eq!(mwd_config_default(ptr::null_mut()), MwdStatus::ErrorNull);
    }
}

#[test]
fn a_frame_that_does_not_fit_is_not_begun() {
    let (output, mut written, mut frame) = (MwdOutput::default(), 77, [9_u8; MWD_FRAME_SIZE]);
    // SAFETY: structs of their own, and lengths that are theirs.
    unsafe {
        assert_eq!(mwd_frame_output(&output, 0, frame.as_mut_ptr(), 10, &mut written), MwdStatus::ErrorTooSmall);
        assert_eq!(written, 77);
        assert!(frame[10..].iter().all(|byte| *byte == 9));
        assert_eq!(mwd_frame_output(&output, 0, ptr::null_mut(), 10, &mut written), MwdStatus::ErrorNull);
        let bytes = frame.len();
        assert_eq!(mwd_frame_output(&output, 0, frame.as_mut_ptr(), bytes, &mut written), MwdStatus::Ok);
        assert_eq!(frame[written - 1], 0);
    }
}
