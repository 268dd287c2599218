//! Magnets that come and go.

use crate::{
    MwdProbe, MwdStatus,
    pointer::{borrow_mut, check, put},
};
use meerkat_mwd::magnet::{FieldUse, HardIronInterval};

/// The field is not used while the magnet is there: it came after the probe was frozen and matches none known before.
pub const MWD_FIELD_WITHHELD: u32 = 0;
/// The magnet's offset is taken out of the field.
pub const MWD_FIELD_CORRECTED: u32 = 1;
/// The magnet came before the probe had turned. The field was used as it came; the magnet was told when it left.
pub const MWD_FIELD_TOLD_AFTERWARDS: u32 = 2;
/// A newer library does something else about it.
pub const MWD_FIELD_OTHERWISE: u32 = 3;

/// Interval in which a magnet was on the probe, an offset of the field that turns with it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdHardIronInterval {
    /// Time at which the offset came, microseconds.
    pub from_us: u64,
    /// Time at which it left or changed, microseconds; `UINT64_MAX` while it lasts.
    pub to_us: u64,
    /// Offset in the calibrated field, body frame, microtesla.
    pub offset_ut: [f32; 3],
    /// 1-sigma of each axis, microtesla.
    pub sigma_ut: [f32; 3],
    /// `MWD_FIELD_...`: use of the field meanwhile.
    pub field_use: u32,
}

impl From<&HardIronInterval> for MwdHardIronInterval {
    fn from(interval: &HardIronInterval) -> Self {
        Self {
            from_us: interval.from_us,
            to_us: interval.to_us.unwrap_or(u64::MAX),
            offset_ut: interval.offset_ut,
            sigma_ut: interval.sigma_ut,
            field_use: match interval.field_use {
                FieldUse::Withheld => MWD_FIELD_WITHHELD,
                FieldUse::Corrected => MWD_FIELD_CORRECTED,
                FieldUse::ToldAfterwards => MWD_FIELD_TOLD_AFTERWARDS,
                _ => MWD_FIELD_OTHERWISE,
            },
        }
    }
}

/// Writes a magnet's interval when it has begun, and again when it has ended. Call it after each sample.
/// `MWD_STATUS_NOTHING`: there is no news.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `interval` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_take_hard_iron_interval(
    probe: *mut MwdProbe,
    interval: *mut MwdHardIronInterval,
) -> MwdStatus {
    if let Err(status) = check(interval) {
        return status;
    }
    // SAFETY: the caller's promise.
    match unsafe { borrow_mut(probe) } {
        Ok(probe) => match probe.probe.take_hard_iron_interval() {
            // SAFETY: the caller's promise.
            Some(news) => unsafe { put(interval, MwdHardIronInterval::from(&news)) },
            None => MwdStatus::Nothing,
        },
        Err(status) => status,
    }
}
