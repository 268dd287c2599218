//! Check of how the sensors are mounted: whether they agree on a turn about each axis of the probe.

use crate::{
    MwdProbe, MwdSample, MwdStatus,
    pointer::{self, borrow_mut, get, place, put},
};
use core::ffi::c_void;
use meerkat_mwd::sensors::MountingCheck;

/// A turn about x, by gyro and gravity. The bits of `MwdMounting`.
pub const MWD_TURN_X_BY_ACCEL: u32 = 1;
/// A turn about y, by gyro and gravity.
pub const MWD_TURN_Y_BY_ACCEL: u32 = 2;
/// A turn about z, by gyro and gravity.
pub const MWD_TURN_Z_BY_ACCEL: u32 = 4;
/// A turn about x, by gyro and field.
pub const MWD_TURN_X_BY_MAG: u32 = 8;
/// A turn about y, by gyro and field.
pub const MWD_TURN_Y_BY_MAG: u32 = 16;
/// A turn about z, by gyro and field.
pub const MWD_TURN_Z_BY_MAG: u32 = 32;

/// Check of signs, units and axes of the sensors by turns of the probe, in storage of the caller.
pub struct MwdMountingCheck {
    check: MountingCheck,
}

/// Findings of a mounting check.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdMounting {
    /// `MWD_TURN_...` of the turns that were seen well enough to judge.
    pub seen: u32,
    /// Those of them on which the sensors do not agree: a sign, a unit or an axis is wrong.
    pub wrong: u32,
    /// Total specific force of the last tenth of a second, m/s^2: gravity at rest; NaN if it is not known.
    pub gravity_m_s2: f32,
    /// Total field of the last tenth of a second, microtesla: the earth's; NaN if it is not known.
    pub field_ut: f32,
}

/// Makes a mounting check that has seen nothing in `storage`, which has at least `MWD_MOUNTING_CHECK_SIZE` bytes and
/// the alignment `MWD_MOUNTING_CHECK_ALIGN`, and points `check` to it.
///
/// # Safety
/// `storage` is NULL or leads to `bytes` bytes that nothing else uses while the check lives; `check` is NULL or leads
/// to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_mounting_check_init(
    storage: *mut c_void,
    bytes: usize,
    check: *mut *mut MwdMountingCheck,
) -> MwdStatus {
    let make = |place: *mut MwdMountingCheck| {
        // SAFETY: `place` gives room for one.
        unsafe { place.write(MwdMountingCheck { check: MountingCheck::new() }) };
    };
    // SAFETY: the caller's promise.
    unsafe { place(storage, bytes, check, make) }
}

/// Takes a sample that was just pushed into `probe`, and writes what turns have shown. While sensors do not agree on a
/// turn, `probe` accepts no new gyro model and no survey is good. Turn the probe by hand about each of its axes, a
/// quarter there and back, twice, each quarter in about two seconds.
///
/// # Safety
/// `check` and `probe` are NULL or from their `_init`; `sample` and `mounting` are NULL or lead to such structs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_mounting_check_push(
    check: *mut MwdMountingCheck,
    probe: *mut MwdProbe,
    sample: *const MwdSample,
    mounting: *mut MwdMounting,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (check, probe, sample) = match unsafe { (borrow_mut(check), borrow_mut(probe), get(sample)) } {
        (Ok(check), Ok(probe), Ok(sample)) => (&mut check.check, probe, sample.to_sample()),
        (Err(status), ..) | (_, Err(status), _) | (.., Err(status)) => return status,
    };
    if let Err(status) = pointer::check(mounting) {
        return status;
    }
    if !probe.is_configured() {
        return MwdStatus::ErrorNotConfigured;
    }
    check.update(&sample, probe.probe.gyro_model().b_rad_s);
    probe.probe.mistrust_mounting(check.wrong());
    let [gravity, field] = check.norms();
    let found = MwdMounting {
        seen: check.seen().bits().into(),
        wrong: check.wrong().bits().into(),
        gravity_m_s2: gravity.unwrap_or(f32::NAN),
        field_ut: field.unwrap_or(f32::NAN),
    };
    // SAFETY: the caller's promise.
    unsafe { put(mounting, found) }
}
