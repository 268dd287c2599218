//! Frames of the telemetry, as docs/telemetry.md lays them out.

use crate::{
    MwdConfig, MwdOutput, MwdSample, MwdStatus, MwdSurveyor, MwdWindow, config,
    pointer::{borrow, check, get, put},
};
use meerkat_mwd::telemetry::{
    AttitudeFrame, Boot, Identification, MAX_FRAME, Payload, ProbeId, RawSample, ResetReason, encode_frame,
    encode_payload,
};

/// Bytes that hold every frame of this interface.
pub const MWD_FRAME_SIZE: usize = 1300;
/// Bytes of a probe's unique number.
pub const MWD_PROBE_ID_SIZE: usize = 12;

const _: () = assert!(MWD_FRAME_SIZE >= MAX_FRAME);

/// Largest payload that this interface encodes, bytes: a boot with its configuration.
const LARGEST: usize = 1_024;

/// Writes a frame and its length.
///
/// # Safety
/// As of the functions below.
unsafe fn write(payload: &impl Payload, sequence: u16, frame: *mut u8, bytes: usize, written: *mut usize) -> MwdStatus {
    if let Err(status) = check(frame).and_then(|()| check(written)) {
        return status;
    }
    let mut buffer = [0; LARGEST];
    let Ok(payload) = encode_payload(payload, &mut buffer).map(|bytes| (kind_of(payload), bytes)) else {
        return MwdStatus::ErrorTooSmall;
    };
    // SAFETY: `bytes` bytes by the caller's promise, and a byte has every value.
    let frame = unsafe { core::slice::from_raw_parts_mut(frame, bytes) };
    match encode_frame(payload.0, sequence, payload.1, frame) {
        // SAFETY: the caller's promise.
        Ok(encoded) => unsafe { put(written, encoded.len()) },
        Err(_) => MwdStatus::ErrorTooSmall,
    }
}

const fn kind_of<P: Payload>(_: &P) -> meerkat_mwd::telemetry::Kind {
    P::KIND
}

/// Frame of all bits of an output (kind 3), with the zero that ends it. `written` becomes its length.
///
/// # Safety
/// `frame` is NULL or leads to `bytes` bytes that hold some value; the other pointers are NULL or lead to what their
/// type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_output(
    output: *const MwdOutput,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { get(output) } {
        Ok(output) => unsafe { write(&output.to_output(), sequence, frame, bytes, written) },
        Err(status) => status,
    }
}

/// Frame of the quantised angles of an output (kind 2).
///
/// # Safety
/// As of `mwd_frame_output`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_attitude(
    output: *const MwdOutput,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { get(output) } {
        Ok(output) => unsafe { write(&AttitudeFrame::of(&output.to_output()), sequence, frame, bytes, written) },
        Err(status) => status,
    }
}

/// Frame of a raw sample (kind 4); `number` counts the samples since the start.
///
/// # Safety
/// As of `mwd_frame_output`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_sample(
    sample: *const MwdSample,
    number: u32,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { get(sample) } {
        Ok(sample) => {
            let payload = RawSample::of(number, &sample.to_sample());
            // SAFETY: the caller's promise.
            unsafe { write(&payload, sequence, frame, bytes, written) }
        }
        Err(status) => status,
    }
}

/// Frame of a window's report (kind 7); `temperature_c` is the window's mean, NaN if it is not known.
///
/// # Safety
/// As of `mwd_frame_output`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_window(
    window: *const MwdWindow,
    temperature_c: f32,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let window = match unsafe { get(window) } {
        Ok(window) => window,
        Err(status) => return status,
    };
    let Some(report) = window.to_report() else { return MwdStatus::ErrorArgument };
    let temperature_c = (!temperature_c.is_nan()).then_some(temperature_c);
    // SAFETY: the caller's promise.
    unsafe { write(&Identification { report, temperature_c }, sequence, frame, bytes, written) }
}

/// Frame of the latest survey of mean vectors (kind 5): `kind` is `MWD_SURVEY_STATIONARY` or `MWD_SURVEY_ROTATING`.
/// `MWD_STATUS_NOTHING`: there is none yet.
///
/// # Safety
/// `surveyor` is NULL or from `mwd_surveyor_init`; the others as of `mwd_frame_output`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_survey(
    surveyor: *const MwdSurveyor,
    kind: u32,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { borrow(surveyor) }.and_then(|surveyor| surveyor.report(kind)) {
        // SAFETY: the caller's promise.
        Ok(Some(report)) => unsafe { write(report, sequence, frame, bytes, written) },
        Ok(None) => MwdStatus::Nothing,
        Err(status) => status,
    }
}

/// Frame with which a probe begins (kind 1): its unique number of `MWD_PROBE_ID_SIZE` bytes and its configuration.
/// A receiver needs it to replay a recording.
///
/// # Safety
/// `probe_id` is NULL or leads to `MWD_PROBE_ID_SIZE` bytes; the others as of `mwd_frame_output`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_frame_boot(
    config: *const MwdConfig,
    probe_id: *const u8,
    sequence: u16,
    frame: *mut u8,
    bytes: usize,
    written: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (config, probe) = match unsafe { (config::read(config), get(probe_id.cast::<[u8; MWD_PROBE_ID_SIZE]>())) } {
        (Ok(config), Ok(probe)) => (config, ProbeId(probe)),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    match config.checked() {
        Ok(config) => {
            let boot = Boot { probe, reset: ResetReason::Unknown, ..Boot::new(config) };
            // SAFETY: the caller's promise.
            unsafe { write(&boot, sequence, frame, bytes, written) }
        }
        Err(status) => status,
    }
}
