//! Whatever a caller hands over, a call comes back with a code and leaves what it was not allowed to change.
#![allow(unsafe_code, clippy::unwrap_used, clippy::disallowed_methods, missing_docs)]

use meerkat_mwd_c::*;
use std::{ffi::CStr, ptr};

/// Storage of the right alignment.
fn storage(bytes: usize) -> Vec<u64> {
    vec![u64::MAX; bytes / 8]
}

fn config() -> MwdConfig {
    let mut config = MwdConfig { version: 0, ..MwdConfig::from(&meerkat_mwd::Config::default()) };
    // SAFETY: a struct of its own.
    let status = unsafe { mwd_config_default(&mut config, MWD_CONFIG_VERSION, size_of::<MwdConfig>()) };
    assert_eq!(status, MwdStatus::Ok);
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
        let mut magnet = std::mem::MaybeUninit::uninit();
        assert_eq!(mwd_probe_take_hard_iron_interval(probe, ptr::null_mut()), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_take_hard_iron_interval(ptr::null_mut(), magnet.as_mut_ptr()), MwdStatus::ErrorNull);
        assert_eq!(mwd_probe_take_hard_iron_interval(probe, magnet.as_mut_ptr()), MwdStatus::Nothing);
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
        let bytes = size_of::<MwdConfig>();
        assert_eq!(mwd_config_default(ptr::null_mut(), MWD_CONFIG_VERSION, bytes), MwdStatus::ErrorNull);
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

/// A program that was compiled with another header has a struct of another size: nothing is written to it, and no more
/// than its version is read of it.
#[test]
fn a_configuration_of_another_header_is_not_touched() {
    let bytes = size_of::<MwdConfig>();
    let mut config = MwdConfig { sample_period_us: 77, ..config() };
    for (version, bytes) in [(MWD_CONFIG_VERSION - 1, bytes), (MWD_CONFIG_VERSION, bytes - 4), (0, 0)] {
        // SAFETY: a struct of its own.
        assert_eq!(unsafe { mwd_config_default(&mut config, version, bytes) }, MwdStatus::ErrorVersion);
        assert_eq!(config.sample_period_us, 77);
    }
    let mut memories = [MWD_PROBE_SIZE, MWD_SURVEYOR_SIZE, MWD_ATTITUDE_FILTER_SIZE].map(storage);
    let [one, other, third] = memories.each_mut().map(|memory| memory.as_mut_ptr());
    let (mut probe, mut surveyor, mut filter) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
    // No more than this belongs to the caller's struct.
    let short = Box::new([u64::from(MWD_CONFIG_VERSION - 1)]);
    let short = short.as_ptr().cast::<MwdConfig>();
    let (mut text, mut frame, mut written) = ([1; 80], [0; MWD_FRAME_SIZE], 0);
    // SAFETY: storage of the size that the macros say, structs of their own, and a version that says which one it is.
    unsafe {
        mwd_probe_init(one.cast(), MWD_PROBE_SIZE, &mut probe);
        mwd_surveyor_init(other.cast(), MWD_SURVEYOR_SIZE, &mut surveyor);
        mwd_attitude_filter_init(third.cast(), MWD_ATTITUDE_FILTER_SIZE, &mut filter);
        assert_eq!(mwd_config_validate(short, text.as_mut_ptr(), 80), MwdStatus::ErrorVersion);
        assert!(CStr::from_ptr(text.as_ptr()).to_str().unwrap().starts_with("version must be "));
        assert_eq!(mwd_probe_configure(probe, short), MwdStatus::ErrorVersion);
        assert_eq!(mwd_surveyor_configure(surveyor, short), MwdStatus::ErrorVersion);
        assert_eq!(mwd_attitude_filter_start(filter, short), MwdStatus::ErrorVersion);
        let bytes = frame.len();
        let boot = mwd_frame_boot(short, [0; 12].as_ptr(), 0, frame.as_mut_ptr(), bytes, &mut written);
        assert_eq!(boot, MwdStatus::ErrorVersion);
    }
}

/// A wrong place for a result is refused before anything is done for it.
#[test]
fn a_call_without_a_place_for_its_result_does_nothing() {
    let mut memories = [MWD_PROBE_SIZE, MWD_SURVEYOR_SIZE, MWD_MOUNTING_CHECK_SIZE].map(storage);
    let [one, other, third] = memories.each_mut().map(|memory| memory.as_mut_ptr());
    let (mut probe, mut surveyor, mut check) = (ptr::null_mut(), ptr::null_mut(), ptr::null_mut());
    let (sample, mut output, mut found) = (MwdSample::default(), MwdOutput::default(), MwdMounting::default());
    let (mut words, mut frame, mut written) = ([0_u32; 2], [9_u8; MWD_FRAME_SIZE], 77);
    // SAFETY: storage of the size that the macros say, and structs of their own; a misaligned pointer is refused.
    unsafe {
        mwd_probe_init(one.cast(), MWD_PROBE_SIZE, &mut probe);
        mwd_surveyor_init(other.cast(), MWD_SURVEYOR_SIZE, &mut surveyor);
        mwd_mounting_check_init(third.cast(), MWD_MOUNTING_CHECK_SIZE, &mut check);
        let config = config();
        assert_eq!(mwd_probe_configure(probe, &config), MwdStatus::Ok);
        assert_eq!(mwd_surveyor_configure(surveyor, &config), MwdStatus::Ok);
        assert_eq!(mwd_probe_push(probe, &sample, &mut output), MwdStatus::Ok);
        let before = third.cast::<u8>();
        let state = || std::slice::from_raw_parts(before, size_of::<MwdMountingCheck>()).to_vec();
        let untouched = state();
        assert_eq!(mwd_mounting_check_push(check, probe, &sample, ptr::null_mut()), MwdStatus::ErrorNull);
        assert!(state() == untouched, "it has taken the sample");
        assert_eq!(mwd_mounting_check_push(check, probe, &sample, &mut found), MwdStatus::Ok);
        assert!(state() != untouched, "and would have");

        let askew = words.as_mut_ptr().cast::<u8>().add(1).cast();
        let mut survey = std::mem::MaybeUninit::<MwdSurvey>::uninit();
        let pushed = mwd_surveyor_push(surveyor, probe, &sample, &output, askew);
        assert_eq!(pushed, MwdStatus::ErrorMisaligned);
        let latest = mwd_surveyor_latest(surveyor, MWD_SURVEY_CONTINUOUS, survey.as_mut_ptr());
        assert_eq!(latest, MwdStatus::Nothing, "it has taken the sample");

        let bytes = frame.len();
        let nowhere = mwd_frame_output(&output, 0, frame.as_mut_ptr(), bytes, ptr::null_mut());
        assert_eq!(nowhere, MwdStatus::ErrorNull);
        assert!(frame.iter().all(|byte| *byte == 9), "a frame without a length");
        assert_eq!(mwd_frame_output(&output, 0, frame.as_mut_ptr(), bytes, &mut written), MwdStatus::Ok);
    }
}

/// A delay of the magnetometer that the caller has taken out makes the azimuth of a tool that turns more certain.
#[test]
fn the_filter_alone_is_told_which_delays_are_known() {
    let sigma = |latency_mag_s| {
        let mut memory = storage(MWD_ATTITUDE_FILTER_SIZE);
        let (mut filter, mut attitude) = (ptr::null_mut(), MwdAttitude::default());
        let config = MwdConfig { latency_mag_s, latency_gyro_s: 0.0, ..config() };
        let start = memory.as_mut_ptr().cast();
        // SAFETY: storage of the size that the macro says, and structs of their own.
        unsafe {
            assert_eq!(mwd_attitude_filter_init(start, MWD_ATTITUDE_FILTER_SIZE, &mut filter), MwdStatus::Ok);
            assert_eq!(mwd_attitude_filter_start(filter, &config), MwdStatus::Ok);
            for k in 0..3_000_u16 {
                let (sine, cosine) = (f32::from(k) * 0.005 * 2.0).sin_cos();
                // Horizontal, and turning about its axis.
                let rate = [0.0, 0.0, 2.0];
                let turned = |[x, y, z]: [f32; 3]| [x * cosine + y * sine, y * cosine - x * sine, z];
                let (force, field) = (turned([9.8, 0.0, 0.0]), turned([-40.0, 10.0, 18.0]));
                mwd_attitude_filter_push(filter, 0.005, rate.as_ptr(), force.as_ptr(), field.as_ptr(), &mut attitude);
            }
        }
        attitude.sigma_azimuth_rad
    };
    let [known, unknown] = [sigma(0.0), sigma(f32::NAN)];
    assert!(known > 0.0 && known < unknown, "{known} {unknown}");
}
