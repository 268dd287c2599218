//! The whole pipeline: samples in; attitude, and the reports of identification, out.

use crate::{
    MwdConfig, MwdGyroModel, MwdOutput, MwdSample, MwdStatus, MwdWindow, config,
    pointer::{borrow, borrow_mut, check, get, place, put},
};
use core::ffi::c_void;
use meerkat_mwd::Probe;

/// The whole pipeline with all its buffers, in storage of the caller.
pub struct MwdProbe {
    pub(crate) probe: Probe,
}

/// Counters since the configuration; every loss is counted in one of them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct MwdCounters {
    /// Samples taken.
    pub samples: u64,
    /// Samples refused because of their time.
    pub out_of_order: u32,
    /// Steps of time over three nominal periods, steps back, and more than three refused samples in a row.
    pub gaps: u32,
    /// Samples with a clipped sensor.
    pub clipped: u32,
    /// Samples without a gyro reading.
    pub gyro_missing: u32,
    /// Updates whose result was not ready in time: `mwd_probe_poll` was called too seldom.
    pub overruns: u32,
    /// Reports of windows that were dropped because none was polled.
    pub reports_lost: u32,
    /// Diagnoses that were dropped because none was taken; this interface takes none.
    pub diagnoses_lost: u32,
    /// Increments that the estimator dropped because it was not polled.
    pub increments_lost: u32,
}

/// Makes a probe without a configuration in `storage`, which has at least `MWD_PROBE_SIZE` bytes and the alignment
/// `MWD_PROBE_ALIGN`, and points `probe` to it.
///
/// # Safety
/// `storage` is NULL or leads to `bytes` bytes that nothing else uses while the probe lives; `probe` is NULL or leads
/// to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_init(storage: *mut c_void, bytes: usize, probe: *mut *mut MwdProbe) -> MwdStatus {
    // SAFETY: the caller's promise. `Probe::new()` is all zero bytes, so that a static of it stands in .bss; a copy of
    // its 90 KiB would first stand on the stack.
    unsafe { place(storage, bytes, probe, |place: *mut MwdProbe| place.write_bytes(0, 1)) }
}

/// Checks a configuration and starts anew from it: everything learnt, found or counted before is forgotten. With an
/// error the probe stays as it was.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `config` is NULL or leads to an `MwdConfig`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_configure(probe: *mut MwdProbe, config: *const MwdConfig) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (probe, config) = match unsafe { (borrow_mut(probe), config::read(config)) } {
        (Ok(probe), Ok(config)) => (probe, config),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    match config.checked() {
        Ok(config) if probe.probe.configure(&config).is_ok() => MwdStatus::Ok,
        Ok(_) => MwdStatus::ErrorConfig,
        Err(status) => status,
    }
}

/// Lets nothing new take effect from a sample time on: the last window ends one latency before it, and its result lands
/// on it. Call it after `mwd_probe_configure` and two latencies ahead; it lasts until the next configuration.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_freeze(probe: *mut MwdProbe, at_us: u64) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { borrow_mut(probe) } {
        Ok(probe) if probe.is_configured() => {
            probe.probe.freeze(at_us);
            MwdStatus::Ok
        }
        Ok(_) => MwdStatus::ErrorNotConfigured,
        Err(status) => status,
    }
}

/// Takes one sample and writes its output. `MWD_STATUS_NOTHING`: the sample was not taken because of its time, and is
/// counted; `output` is as it was.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `sample` and `output` are NULL or lead to such structs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_push(
    probe: *mut MwdProbe,
    sample: *const MwdSample,
    output: *mut MwdOutput,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (probe, sample) = match unsafe { (borrow_mut(probe), get(sample)) } {
        (Ok(probe), Ok(sample)) => (probe, sample),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    if let Err(status) = check(output) {
        return status;
    }
    if !probe.is_configured() {
        return MwdStatus::ErrorNotConfigured;
    }
    match probe.probe.push(&sample.to_sample()) {
        // SAFETY: the caller's promise.
        Some(taken) => unsafe { put(output, MwdOutput::from(&taken)) },
        None => MwdStatus::Nothing,
    }
}

/// Does about `budget` units of identification work, of up to 500 cycles each. Call it after each sample with
/// `mwd_probe_poll_budget`. `MWD_STATUS_OK`: a window is reported in `window`; `MWD_STATUS_NOTHING`: none is ready.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `window` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_poll(probe: *mut MwdProbe, budget: u32, window: *mut MwdWindow) -> MwdStatus {
    if let Err(status) = check(window) {
        return status;
    }
    // SAFETY: the caller's promise.
    match unsafe { borrow_mut(probe) } {
        Ok(probe) => match probe.probe.poll(budget) {
            // SAFETY: the caller's promise.
            Some(report) => unsafe { put(window, MwdWindow::from(&report)) },
            None => MwdStatus::Nothing,
        },
        Err(status) => status,
    }
}

/// Returns the budget for `mwd_probe_poll` after each sample with which every result is ready when it is due; 0 before
/// a configuration.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_poll_budget(probe: *const MwdProbe) -> u32 {
    // SAFETY: the caller's promise.
    unsafe { borrow(probe) }.map_or(0, |probe| probe.probe.poll_budget())
}

/// Writes the gyro model that flies.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `model` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_gyro_model(probe: *const MwdProbe, model: *mut MwdGyroModel) -> MwdStatus {
    // SAFETY: the caller's promise.
    match unsafe { borrow(probe) } {
        Ok(probe) => unsafe { put(model, MwdGyroModel::from(probe.probe.gyro_model())) },
        Err(status) => status,
    }
}

/// Writes the counters.
///
/// # Safety
/// `probe` is NULL or from `mwd_probe_init`; `counters` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_probe_counters(probe: *const MwdProbe, counters: *mut MwdCounters) -> MwdStatus {
    // SAFETY: the caller's promise.
    let probe = match unsafe { borrow(probe) } {
        Ok(probe) => probe,
        Err(status) => return status,
    };
    let counted = probe.probe.counters();
    let all = MwdCounters {
        samples: counted.samples,
        out_of_order: counted.out_of_order,
        gaps: counted.gaps,
        clipped: counted.clipped,
        gyro_missing: counted.gyro_missing,
        overruns: counted.overruns,
        reports_lost: counted.reports_lost,
        diagnoses_lost: counted.diagnoses_lost,
        increments_lost: counted.increments_lost,
    };
    // SAFETY: the caller's promise.
    unsafe { put(counters, all) }
}

impl MwdProbe {
    /// A configuration has a sample period; before one it is zero.
    pub(crate) fn is_configured(&self) -> bool {
        self.probe.config().sample_period_us > 0
    }
}
