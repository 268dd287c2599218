//! The attitude filter alone, for parts with little memory and for rates that something else has compensated.

use crate::{
    MwdAttitude, MwdConfig, MwdStatus, config,
    pointer::{borrow_mut, check, get, place, put},
};
use core::ffi::c_void;
use meerkat_mwd::attitude::{AttitudeFilter, AttitudeFlags};

/// The attitude filter, in storage of the caller.
pub struct MwdAttitudeFilter {
    filter: AttitudeFilter,
    started: bool,
}

/// Makes a filter that was not started in `storage`, which has at least `MWD_ATTITUDE_FILTER_SIZE` bytes and the
/// alignment `MWD_ATTITUDE_FILTER_ALIGN`, and points `filter` to it.
///
/// # Safety
/// `storage` is NULL or leads to `bytes` bytes that nothing else uses while the filter lives; `filter` is NULL or leads
/// to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_attitude_filter_init(
    storage: *mut c_void,
    bytes: usize,
    filter: *mut *mut MwdAttitudeFilter,
) -> MwdStatus {
    let make = |place: *mut MwdAttitudeFilter| {
        let fresh = MwdAttitudeFilter { filter: AttitudeFilter::new(), started: false };
        // SAFETY: `place` gives room for one.
        unsafe { place.write(fresh) };
    };
    // SAFETY: the caller's promise.
    unsafe { place(storage, bytes, filter, make) }
}

/// Checks a configuration and starts anew from its fields `earth_...`, `attitude_...` and `identification_motion`, and
/// from whether `latency_gyro_s` and `latency_mag_s` are known. A known delay is one that the caller has taken out of
/// rate and field; one that is NaN widens the deviations while the tool turns.
///
/// # Safety
/// `filter` is NULL or from `mwd_attitude_filter_init`; `config` is NULL or leads to an `MwdConfig`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_attitude_filter_start(
    filter: *mut MwdAttitudeFilter,
    config: *const MwdConfig,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (filter, config) = match unsafe { (borrow_mut(filter), config::read(config)) } {
        (Ok(filter), Ok(config)) => (filter, config),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    match config.checked() {
        Ok(config) => {
            filter.filter.start(&config.attitude, &config.earth, config.identification.motion);
            filter.filter.gyro_delay_known(config.latency.gyro_s.is_some());
            filter.filter.mag_delay_known(config.latency.mag_s.map(|_| 0.0));
            filter.started = true;
            MwdStatus::Ok
        }
        Err(status) => status,
    }
}

/// Takes one sample: turns by a compensated rate for `dt_s` seconds, then compares with the vectors, then writes the
/// attitude. `accel_m_s2` and `mag_ut` are NULL where the sensor gave no reading. `MWD_STATUS_NOTHING`: no gravity has
/// aligned the filter yet.
///
/// # Safety
/// `filter` is NULL or from `mwd_attitude_filter_init`; `rate_rad_s`, `accel_m_s2` and `mag_ut` are NULL or lead to
/// three numbers; `attitude` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_attitude_filter_push(
    filter: *mut MwdAttitudeFilter,
    dt_s: f32,
    rate_rad_s: *const f32,
    accel_m_s2: *const f32,
    mag_ut: *const f32,
    attitude: *mut MwdAttitude,
) -> MwdStatus {
    if let Err(status) = check(attitude) {
        return status;
    }
    let vector = |pointer: *const f32| match pointer.is_null() {
        true => Ok(None),
        // SAFETY: the caller's promise.
        false => unsafe { get(pointer.cast::<[f32; 3]>()) }.map(Some),
    };
    // SAFETY: the caller's promise.
    let (filter, rate) = match unsafe { (borrow_mut(filter), get(rate_rad_s.cast::<[f32; 3]>())) } {
        (Ok(filter), Ok(rate)) => (filter, rate),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    let (accel, mag) = match (vector(accel_m_s2), vector(mag_ut)) {
        (Ok(accel), Ok(mag)) => (accel, mag),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    if !filter.started {
        return MwdStatus::ErrorNotConfigured;
    }
    let all = rate.iter().chain(accel.iter().flatten()).chain(mag.iter().flatten());
    // Bounds as of `Sample::sanitised`: a larger number is a defect of the driver.
    if !(0.0..=1.0).contains(&dt_s) || !all.copied().all(|x: f32| (-1e4..=1e4).contains(&x)) {
        return MwdStatus::ErrorArgument;
    }
    let rate = meerkat_mwd::nalgebra::Vector3::from(rate) - filter.filter.earth_rate_rad_s();
    filter.filter.propagate(dt_s, &rate);
    filter.filter.observe(accel.map(Into::into).as_ref(), mag.map(Into::into).as_ref());
    match filter.filter.attitude(AttitudeFlags::empty()) {
        // SAFETY: the caller's promise.
        Some(formed) => unsafe { put(attitude, MwdAttitude::from(&formed)) },
        None => MwdStatus::Nothing,
    }
}
