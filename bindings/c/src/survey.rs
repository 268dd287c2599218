//! Surveys: the tool's direction at a station, while rotating and at every sample.

use crate::{
    MwdConfig, MwdOutput, MwdProbe, MwdSample, MwdStatus, config,
    pointer::{borrow, borrow_mut, check, get, place, put},
};
use core::ffi::c_void;
use meerkat_mwd::survey::{Grade, Survey, SurveyReport, Surveys, ToolfaceKind, Uncertain};

/// Survey of the attitude filter at one sample.
pub const MWD_SURVEY_CONTINUOUS: u32 = 0;
/// Survey of mean vectors at rest; also a bit of the news of `mwd_surveyor_push`.
pub const MWD_SURVEY_STATIONARY: u32 = 1;
/// Survey of mean vectors over whole turns; also a bit of the news of `mwd_surveyor_push`.
pub const MWD_SURVEY_ROTATING: u32 = 2;
/// Every possible check is within its limit.
pub const MWD_GRADE_GOOD: u32 = 0;
/// A check is beyond its limit.
pub const MWD_GRADE_DOUBTFUL: u32 = 1;
/// A check is far beyond its limit, or a measurement that it needs is missing.
pub const MWD_GRADE_BAD: u32 = 2;
/// Not graded: a survey of the attitude filter.
pub const MWD_GRADE_NONE: u32 = 3;

/// Taker of surveys, in storage of the caller.
pub struct MwdSurveyor {
    surveyor: Surveys,
}

/// Value with its standard deviation, in the unit that the field's name ends with; both NaN if it is not known.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdUncertain {
    /// Value.
    pub value: f32,
    /// Standard deviation.
    pub sigma: f32,
}

/// Survey: the tool's direction, and the earth as its sensors see it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MwdSurvey {
    /// Time of its first sample, microseconds.
    pub t_start_us: u64,
    /// Time of its last sample, microseconds.
    pub t_end_us: u64,
    /// Angle of the tool axis from the vertical, radians.
    pub inclination_rad: MwdUncertain,
    /// Azimuth of the tool axis from magnetic north, radians.
    pub magnetic_azimuth_rad: MwdUncertain,
    /// Azimuth from true north, radians.
    pub true_azimuth_rad: MwdUncertain,
    /// Azimuth from grid north, radians.
    pub grid_azimuth_rad: MwdUncertain,
    /// Gravity toolface, radians, clockwise looking down-hole.
    pub gravity_toolface_rad: MwdUncertain,
    /// Magnetic toolface, radians.
    pub magnetic_toolface_rad: MwdUncertain,
    /// Total gravity, m/s^2.
    pub gravity_m_s2: MwdUncertain,
    /// Total field, microtesla.
    pub field_ut: MwdUncertain,
    /// Dip below the horizon, radians.
    pub dip_rad: MwdUncertain,
    /// Mean temperature, degrees Celsius; NaN if it is not known.
    pub temperature_c: f32,
    /// 1 if the magnetic toolface applies, 0 for the gravity toolface.
    pub magnetic_toolface_applies: u32,
    /// 1 if the tool turned about its axis.
    pub rotating: u32,
    /// `MWD_GRADE_...`.
    pub grade: u32,
}

fn uncertain(value: Option<Uncertain>) -> MwdUncertain {
    let Uncertain { value, sigma } = value.unwrap_or(Uncertain { value: f32::NAN, sigma: f32::NAN });
    MwdUncertain { value, sigma }
}

impl MwdSurvey {
    fn of(survey: &Survey, grade: u32) -> Self {
        Self {
            t_start_us: survey.t_start_us,
            t_end_us: survey.t_end_us,
            inclination_rad: uncertain(Some(survey.inclination_rad)),
            magnetic_azimuth_rad: uncertain(survey.magnetic_azimuth_rad),
            true_azimuth_rad: uncertain(survey.true_azimuth_rad),
            grid_azimuth_rad: uncertain(survey.grid_azimuth_rad),
            gravity_toolface_rad: uncertain(survey.gravity_toolface_rad),
            magnetic_toolface_rad: uncertain(survey.magnetic_toolface_rad),
            gravity_m_s2: uncertain(survey.gravity_m_s2),
            field_ut: uncertain(survey.field_ut),
            dip_rad: uncertain(survey.dip_rad),
            temperature_c: survey.temperature_c.unwrap_or(f32::NAN),
            magnetic_toolface_applies: (survey.toolface_kind == ToolfaceKind::Magnetic).into(),
            rotating: survey.rotating.into(),
            grade,
        }
    }
}

fn grade(grade: Grade) -> u32 {
    match grade {
        Grade::Good => MWD_GRADE_GOOD,
        Grade::Doubtful => MWD_GRADE_DOUBTFUL,
        // A grade of a newer library is no better.
        _ => MWD_GRADE_BAD,
    }
}

impl MwdSurveyor {
    /// Latest survey of mean vectors; `Err` for a number that is no such survey.
    pub(crate) fn report(&self, kind: u32) -> Result<Option<&SurveyReport>, MwdStatus> {
        match kind {
            MWD_SURVEY_STATIONARY => Ok(self.surveyor.stationary()),
            MWD_SURVEY_ROTATING => Ok(self.surveyor.rotating()),
            _ => Err(MwdStatus::ErrorArgument),
        }
    }
}

/// Makes a surveyor without a configuration in `storage`, which has at least `MWD_SURVEYOR_SIZE` bytes and the
/// alignment `MWD_SURVEYOR_ALIGN`, and points `surveyor` to it.
///
/// # Safety
/// `storage` is NULL or leads to `bytes` bytes that nothing else uses while the surveyor lives; `surveyor` is NULL or
/// leads to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_surveyor_init(
    storage: *mut c_void,
    bytes: usize,
    surveyor: *mut *mut MwdSurveyor,
) -> MwdStatus {
    let make = |place: *mut MwdSurveyor| {
        // SAFETY: `place` gives room for one.
        unsafe { place.write(MwdSurveyor { surveyor: Surveys::new() }) };
    };
    // SAFETY: the caller's promise.
    unsafe { place(storage, bytes, surveyor, make) }
}

/// Checks a configuration and starts anew from its fields `earth_...` and `survey_...`.
///
/// # Safety
/// `surveyor` is NULL or from `mwd_surveyor_init`; `config` is NULL or leads to an `MwdConfig`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_surveyor_configure(surveyor: *mut MwdSurveyor, config: *const MwdConfig) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (surveyor, config) = match unsafe { (borrow_mut(surveyor), config::read(config)) } {
        (Ok(surveyor), Ok(config)) => (&mut surveyor.surveyor, config),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    match config.checked() {
        Ok(config) if surveyor.configure(&config.earth, &config.survey).is_ok() => MwdStatus::Ok,
        Ok(_) => MwdStatus::ErrorConfig,
        Err(status) => status,
    }
}

/// Takes a sample that was just pushed into `probe` and gave `output`. `news` becomes the sum of
/// `MWD_SURVEY_STATIONARY` and `MWD_SURVEY_ROTATING` for what it completed; `mwd_surveyor_latest` has it then.
///
/// # Safety
/// `surveyor` and `probe` are NULL or from their `_init`; the other pointers are NULL or lead to what their type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_surveyor_push(
    surveyor: *mut MwdSurveyor,
    probe: *const MwdProbe,
    sample: *const MwdSample,
    output: *const MwdOutput,
    news: *mut u32,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let (surveyor, probe) = match unsafe { (borrow_mut(surveyor), borrow(probe)) } {
        (Ok(surveyor), Ok(probe)) => (&mut surveyor.surveyor, probe),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    // SAFETY: the caller's promise.
    let (sample, output) = match unsafe { (get(sample), get(output)) } {
        (Ok(sample), Ok(output)) => (sample.to_sample(), output.to_output()),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    if let Err(status) = check(news) {
        return status;
    }
    if surveyor.config().is_none() || !probe.is_configured() {
        return MwdStatus::ErrorNotConfigured;
    }
    let completed = surveyor.push(&probe.probe.survey_input(&sample, &output));
    let surveys = u32::from(completed.bits()) & (MWD_SURVEY_STATIONARY | MWD_SURVEY_ROTATING);
    // SAFETY: the caller's promise.
    unsafe { put(news, surveys) }
}

/// Writes the latest survey of a kind, `MWD_SURVEY_...`. `MWD_STATUS_NOTHING`: there is none yet.
///
/// # Safety
/// `surveyor` is NULL or from `mwd_surveyor_init`; `survey` is NULL or leads to such a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mwd_surveyor_latest(
    surveyor: *const MwdSurveyor,
    kind: u32,
    survey: *mut MwdSurvey,
) -> MwdStatus {
    // SAFETY: the caller's promise.
    let surveyor = match unsafe { borrow(surveyor) } {
        Ok(surveyor) => surveyor,
        Err(status) => return status,
    };
    let found = if kind == MWD_SURVEY_CONTINUOUS {
        Ok(surveyor.surveyor.continuous().map(|survey| MwdSurvey::of(&survey, MWD_GRADE_NONE)))
    } else {
        let of = |report: &SurveyReport| MwdSurvey::of(&report.survey, grade(report.quality.grade));
        surveyor.report(kind).map(|report| report.map(of))
    };
    match found {
        // SAFETY: the caller's promise.
        Ok(Some(found)) => unsafe { put(survey, found) },
        Ok(None) => MwdStatus::Nothing,
        Err(status) => status,
    }
}
