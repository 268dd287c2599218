//! Results of a flight beside attitude and parameters: surveys, drilling dynamics, calibrated vectors.

use meerkat_mwd::{
    Probe,
    config::ConfigError,
    survey::{
        BurstRecorder, BurstSample, DrillingDynamics, SlidingToolface, SurveyNews, SurveyReport, Surveyor,
        VibrationDose,
    },
};

use crate::trace::Trace;

/// Calibrated vectors of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// Time of acquisition, microseconds.
    pub t_us: u64,
    /// Specific force, m/s^2; `None` if it is not usable.
    pub force_m_s2: Option<[f32; 3]>,
    /// Field, microtesla; `None` if it is not usable.
    pub field_ut: Option<[f32; 3]>,
}

/// Results of a flight beside attitude and parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Watched {
    /// Surveys at rest and over whole turns, in the order of their completion.
    pub surveys: Vec<SurveyReport>,
    /// Windows of drilling dynamics.
    pub dynamics: Vec<DrillingDynamics>,
    /// Sum of the windows.
    pub dose: VibrationDose,
    /// Toolfaces while sliding.
    pub toolfaces: Vec<SlidingToolface>,
    /// One per sample.
    pub calibrated: Vec<Calibrated>,
}

/// Flies a configured probe over a trace and watches it.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn watched(probe: Box<Probe>, trace: &Trace) -> Result<Watched, ConfigError> {
    let mut calibrated = Vec::with_capacity(trace.len());
    let seen = watch(probe, trace, |vectors| calibrated.push(vectors))?;
    Ok(Watched { calibrated, ..seen })
}

/// Flies a configured probe over a trace; the vectors of its samples go to `calibrated`.
fn watch(mut probe: Box<Probe>, trace: &Trace, mut calibrated: impl FnMut(Calibrated)) -> Result<Watched, ConfigError> {
    let (config, mut surveyor) = (*probe.config(), Surveyor::new());
    surveyor.configure(&config.earth, &config.survey)?;
    let mut seen = Watched::default();
    for sample in trace.samples() {
        if let Some(output) = probe.push(&sample) {
            let input = probe.survey_input(&sample, &output);
            let news = surveyor.push(&input);
            seen.surveys.extend(surveyor.stationary().filter(|_| news.contains(SurveyNews::STATIONARY)).copied());
            seen.surveys.extend(surveyor.rotating().filter(|_| news.contains(SurveyNews::ROTATING)).copied());
            seen.dynamics.extend(surveyor.dynamics().filter(|_| news.contains(SurveyNews::DYNAMICS)).copied());
            seen.toolfaces.extend(surveyor.sliding_toolface().filter(|_| news.contains(SurveyNews::TOOLFACE)).copied());
            calibrated(Calibrated { t_us: sample.t_us, force_m_s2: input.force_m_s2, field_ut: input.field_ut });
        }
        probe.poll(probe.poll_budget());
        probe.take_diagnosis();
    }
    seen.dose = *surveyor.dose();
    Ok(seen)
}

/// Raw samples of a flight's worst second, at up to 3.2 kHz; of a slower probe a little more than the second.
#[must_use]
pub fn worst_second(probe: Box<Probe>, trace: &Trace) -> Vec<BurstSample> {
    match probe.config().sample_period_us {
        0..=624 => worst::<3_200>(probe, trace),
        625..=1_249 => worst::<1_600>(probe, trace),
        1_250..=2_499 => worst::<800>(probe, trace),
        2_500..=4_999 => worst::<400>(probe, trace),
        5_000..=9_999 => worst::<200>(probe, trace),
        _ => worst::<100>(probe, trace),
    }
}

fn worst<const N: usize>(mut probe: Box<Probe>, trace: &Trace) -> Vec<BurstSample> {
    let mut recorder = Box::new(BurstRecorder::<N>::new());
    for sample in trace.samples() {
        if let Some(output) = probe.push(&sample) {
            recorder.push(&probe.survey_input(&sample, &output));
        }
        probe.poll(probe.poll_budget());
        probe.take_diagnosis();
    }
    recorder.worst().copied().collect()
}

/// Surveys of a flight, at rest and over whole turns, in the order of their completion.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn surveys(probe: Box<Probe>, trace: &Trace) -> Result<Vec<SurveyReport>, ConfigError> {
    Ok(watch(probe, trace, |_| {})?.surveys)
}

/// Windows of drilling dynamics of a flight.
///
/// # Errors
/// The field of the configuration that cannot be used.
pub fn dynamics(probe: Box<Probe>, trace: &Trace) -> Result<Vec<DrillingDynamics>, ConfigError> {
    Ok(watch(probe, trace, |_| {})?.dynamics)
}
