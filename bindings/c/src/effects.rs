//! Effects that are taken out of the readings.

use crate::{
    MwdProbe, MwdStatus,
    pointer::{borrow, check, put},
    text,
};
use core::ffi::c_char;

/// Bytes of a name, with the zero that ends it.
pub const MWD_NAME_SIZE: usize = 32;
/// Largest number of effects that are taken out at a time.
pub const MWD_MAX_EFFECTS: usize = 8;

const _: () = assert!(MWD_MAX_EFFECTS == meerkat_mwd::compensation::MAX_ACTIVE);

/// Physical error of a sensor that was found and is taken out of its readings.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdEffect {
    /// Name, for instance `gyro_bias_temperature`.
    pub name: [c_char; MWD_NAME_SIZE],
    /// Number of parameters.
    pub parameters: u32,
    /// Values of the parameters, SI (field: microtesla); 0 beyond their number.
    pub value: [f32; 9],
    /// 1-sigma of each.
    pub sigma: [f32; 9],
}

/// Writes the effects that are taken out, at most `room` of them, and their number to `count`;
/// `MWD_MAX_EFFECTS` is enough room for all. `MWD_STATUS_ERROR_TOO_SMALL`: there are more than `room`.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `effects` is NULL or leads to `room` such structs; `count` is NULL or
/// leads to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_effects(
    probe: *const MwdProbe,
    effects: *mut MwdEffect,
    room: usize,
    count: *mut usize,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let probe = match unsafe { borrow(probe) } {
        Ok(probe) => &probe.probe,
        Err(status) => return status,
    };
    let active = probe.effects();
    let number = active.iter().count();
    if (1..=room).contains(&number)
        && let Err(status) = check(effects)
    {
        return status;
    }
    // SAFETY: the caller's promise.
    let status = unsafe { put(count, number) };
    if status != MwdStatus::Ok || number == 0 {
        return status;
    }
    if number > room {
        return MwdStatus::ErrorTooSmall;
    }
    for (place, found) in active.iter().enumerate() {
        let effect = probe.library().get(usize::from(found.index));
        let report = MwdEffect {
            name: text::name(effect.map_or("", |effect| effect.name())),
            parameters: effect.map_or(0, |effect| effect.parameters().len()) as u32,
            value: found.parameters,
            sigma: found.sigma,
        };
        // SAFETY: `place` is below `room`, and the caller's promise.
        let status = unsafe { put(effects.wrapping_add(place), report) };
        if status != MwdStatus::Ok {
            return status;
        }
    }
    MwdStatus::Ok
}
